"""The packet of the real-time interface, port 30003.

The packet has the layout of UR's software 5.10. The order of the values has not changed
since version 3.0: later versions only append values. The first number is the size of
the packet, so older clients can read the values that they support. Source:
https://docs.universal-robots.com/tutorials/communication-protocol-tutorials/realtime-guide.html
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from struct import Struct
from typing import TYPE_CHECKING, Final

from tool0.ur.rtde import quantities as q

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox

N_VALUES: Final = 152
SIZE: Final = 4 + 8 * N_VALUES
"""Size of the packet, including the number with the size [bytes]."""
_PACKET: Final = Struct(f">i{N_VALUES}d")


def realtime_packet(box: UrControlBox) -> bytes:
    """Return a packet with the current state of a control box."""
    return _PACKET.pack(SIZE, *_values(box))


def _values(box: UrControlBox) -> Iterator[float]:
    """Yield the values after the size, in the order of UR's guide."""
    state = box.state
    yield box.time
    for six in (
        box.target_q,
        box.target_qd,
        box.target_qdd,
        q.currents(box),  # target currents
        box.effort,  # target moments
        box.q,
        box.qd,
        q.currents(box),
        q.currents(box),  # control currents
        box.tcp_pose(),
        box.tcp_speed(),
        box.tcp_wrench(),
        box.tcp_pose(target=True),
        box.tcp_speed(target=True),
    ):
        yield from six
    yield float(q.digital_bits(state.digital_inputs))
    yield from (q.ROOM_TEMPERATURE,) * 6
    yield from (0.0, 0.0)  # execution time of the controller, test value
    yield float(state.robot_mode)
    yield from map(float, q.joint_modes(box))
    yield float(state.safety_mode)
    yield from _unused(6)
    yield from q.tool_accelerometer(box)
    yield from _unused(6)
    yield state.speed_scaling
    yield from _unused(3)  # linear momentum; two values for UR's internal use
    yield q.SUPPLY_VOLTAGE
    yield q.voltage(box)
    yield q.robot_current(box)
    yield from (q.voltage(box),) * 6
    yield float(q.digital_bits(state.digital_outputs))
    yield float(box.programs.state)
    yield from q.elbow_position(box)
    yield from q.elbow_velocity(box)
    yield float(state.safety_mode)  # same as the safety status
    yield from _unused(3)
    yield state.payload.mass
    yield from state.payload.center_of_gravity
    yield from q.payload_moments(box)


def _unused(count: int) -> Sequence[float]:
    return (0.0,) * count
