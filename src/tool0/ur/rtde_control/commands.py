"""The commands of ur_rtde's control program.

The numbers are those of ur_rtde's ``process_cmd``. Arguments start at register 0. A
command that fails ends the program, as an error in URScript does.
"""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable, Sequence
from typing import TYPE_CHECKING, Final, final

from tool0.errors import ControlError
from tool0.motion.moves import Move
from tool0.protocol.arm_motion import ZeroWrench
from tool0.protocol.control_box import SetPayload, SetTcp, StopProtectively
from tool0.ur.moves import Moves
from tool0.ur.pose import pose_of, transform_of
from tool0.ur.rtde_control.compliance import Compliance
from tool0.ur.rtde_control.exchange import Exchange
from tool0.ur.rtde_control.motions import Motions
from tool0.ur.torques import Torques

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox
    from tool0.ur.tool_contact import ToolHistory

NO_OFFSET: Final = (0.0,) * 6
LAST_SCALE: Final = 17
"""Register with the last friction scale of ``directTorque``."""
UPRIGHT: Final = math.radians(1.0)
"""Maximum angle between the gravity that a client sets and the base's axis [rad]."""

Action = Callable[[], Awaitable[None] | None]
DYNAMICS: Final = frozenset({66, 67, 68, 69, 70, 71})
STREAMED: Final = DYNAMICS | {6, 9, 10, 11, 12, 24, 25, 26, 27, 38, 55, 58, 99}
"""Commands that are executed every time they are written. The commands include
``servoC`` (12), ``setExternalForceTorque`` (55) and ``kickWatchdog`` (99), because the
client does not wait for these commands either."""
POLLED: Final = DYNAMICS | {25, 26, 27, 38, 58}
"""Commands that are executed again at every update: queries with answers that must stay
up to date without a request, and ``directTorque``, which continues until the next
command."""


@final
class Commands:
    """The commands of an uploaded control program."""

    SET_WATCHDOG: Final = 35

    def __init__(
        self,
        box: UrControlBox,
        exchange: Exchange,
        history: ToolHistory,
        path: Sequence[Move],
        wake: Callable[[], None],
    ) -> None:
        """Use ``path`` for command 45; ``wake`` makes the server check for contacts."""
        self._box, self._exchange, self._history = box, exchange, history
        self._torques = Torques(box)
        moves = Moves(box)
        self._motions = motions = Motions(
            box, exchange, history, moves, path=path, wake=wake
        )
        compliance = Compliance(box, exchange, moves)
        self._actions: dict[int, Action] = {
            1: motions.move_joints,
            2: motions.move_joints_to_pose,
            3: motions.move_tool,
            4: motions.move_tool_to_joints,
            6: compliance.force_mode,
            7: compliance.end_force_mode,
            8: self._zero_wrench,
            9: motions.speed_joints,
            10: motions.speed_tool,
            11: motions.servo_joints,
            12: motions.servo_circular,
            15: motions.end_speed,
            16: motions.end_servo,
            17: self._set_payload,
            18: compliance.start_teaching,
            19: compliance.end_freedrive,
            20: compliance.set_damping,
            21: compliance.set_gain_scaling,
            24: motions.servo_tool,
            25: self._tool_contact,
            26: lambda: exchange.answer([1.0 / box.rate]),
            27: lambda: exchange.answer(history.positions(exchange.integer(1))),
            28: lambda: exchange.answer(motions.waypoint),
            29: self._set_tcp,
            30: lambda: exchange.answer(box.inverse(exchange.six(0), exchange.six(6))),
            31: self._stop_protectively,
            33: motions.stop_tool,
            34: motions.stop_joints,
            35: lambda: None,  # executed by the server
            36: lambda: exchange.answer_integer(box.has_inverse(exchange.six(0))),
            37: lambda: exchange.answer_integer(self._is_within_limits()),
            38: self._external_torques,
            39: self._compose_poses,
            40: lambda: exchange.answer(box.tcp),
            41: motions.start_jog,
            42: motions.end_jog,
            43: lambda: exchange.answer(box.tcp_pose()),
            44: self._forward,
            45: motions.move_path,
            46: lambda: exchange.answer(box.inverse(exchange.six(0))),
            47: lambda: exchange.answer_integer(history.is_steady()),
            51: motions.move_until_contact,
            52: compliance.start_freedrive,
            53: compliance.end_freedrive,
            54: lambda: exchange.answer_integer(0),  # not at a limit
            55: lambda: None,  # the wrist's built-in sensor is used
            56: self._enable_wrench_input,
            57: self._enable_wrench_input,
            58: lambda: exchange.answer(box.forward(box.q, NO_OFFSET)),
            59: self._check_gravity,
            60: lambda: exchange.answer_integer(box.has_inverse(exchange.six(0))),
            61: self._has_inverse_near,
            62: motions.start_contact_detection,
            63: motions.end_contact_detection,
            64: lambda: exchange.answer_integer(motions.contact_steps),
            65: self._set_payload,
            66: self._drive_torques,
            # As in the original program, the client's arguments are ignored, and the
            # answer is for the current posture.
            67: lambda: exchange.answer_matrix(box.dynamics.mass_matrix()),
            68: lambda: exchange.answer(box.dynamics.velocity_torques()),
            69: lambda: exchange.answer(box.target_qdd),
            70: lambda: exchange.answer_matrix(box.dynamics.jacobian()),
            71: lambda: exchange.answer_matrix(box.dynamics.jacobian_derivative()),
            99: lambda: None,  # executed by the server
        }

    def is_streamed(self, command: int) -> bool:
        """Return whether a command is executed every time it is written."""
        return command in STREAMED

    def is_polled(self, command: int) -> bool:
        """Return whether a command's answer must be kept up to date."""
        return command in POLLED

    async def execute(self, command: int) -> None:
        """Execute a command and return when it is complete.

        Raises:
            Tool0Error: If the command fails.
        """
        action = self._actions.get(command)
        if action is None:
            raise ControlError(
                f"ur_rtde's command {command} is not supported; the arm holds"
            )
        pending = action()
        if pending is not None:
            await pending

    async def look_for_contact(self) -> None:
        """Return to the contact point if contact detection has detected a contact."""
        await self._motions.look_for_contact()

    def check(self) -> None:
        """Raise the error that ended an asynchronous motion, if there was one."""
        self._motions.check()

    async def close(self) -> None:
        """End asynchronous motions."""
        await self._motions.close()

    # ---- settings -------------------------------------------------------------------

    async def _zero_wrench(self) -> None:
        await self._box.call(ZeroWrench(arm=self._box.arm))

    async def _set_payload(self) -> None:
        """Set the mass and center of gravity; zeros keep the current center."""
        center = self._exchange.three(1)
        if not any(center):
            center = self._box.state.payload.center_of_gravity
        mass = self._exchange.number(0)
        request = SetPayload(arm=self._box.arm, mass=mass, center_of_gravity=center)
        await self._box.call(request)

    async def _set_tcp(self) -> None:
        pose = self._exchange.six(0)
        await self._box.call(SetTcp(arm=self._box.arm, pose=pose))
        await self._box.until(lambda: self._box.tcp == pose)

    async def _stop_protectively(self) -> None:
        request = StopProtectively(arm=self._box.arm, reason="protective_stop()")
        await self._box.call(request)

    async def _drive_torques(self) -> None:
        """Apply torques to the joints with friction scales: direct_torque.

        Older clients send a flag instead of the scales.
        """
        exchange = self._exchange
        torques = exchange.six(0)
        if exchange.has_number(LAST_SCALE):
            await self._torques.set(torques, exchange.six(6), exchange.six(12))
        elif exchange.integer(1):
            await self._torques.set(torques)
        else:
            await self._torques.set(torques, NO_OFFSET, NO_OFFSET)

    def _enable_wrench_input(self) -> None:
        """Select RTDE's external_force_torque or the wrist's built-in sensor."""
        is_enabled = self._exchange.integer(1) != 0
        offset = self._exchange.three(1) if is_enabled else None
        self._box.rtde_sensor.set_offset(offset)

    def _check_gravity(self) -> None:
        """Check that the requested gravity is equal to the simulation's gravity."""
        x, y, z = self._exchange.three(0)
        if not math.atan2(math.hypot(x, y), z) <= UPRIGHT:
            raise ControlError(
                f"set_gravity([{x:g}, {y:g}, {z:g}]): the arm stands upright, so the "
                "reaction to gravity is along [0, 0, 1] of its base"
            )

    # ---- queries --------------------------------------------------------------------

    def _tool_contact(self) -> None:
        self._exchange.answer_integer(self._history.contact(self._exchange.three(0)))

    def _external_torques(self) -> None:
        """Answer with the drive torques that resist external tool forces [N·m]."""
        efforts = self._box.posture().efforts(*self._box.flange_wrench())
        self._exchange.answer([-effort for effort in efforts])

    def _compose_poses(self) -> None:
        first, second = self._exchange.six(0), self._exchange.six(6)
        self._exchange.answer(pose_of(transform_of(first) @ transform_of(second)))

    def _forward(self) -> None:
        """Answer with the pose of the client's TCP, or of the box's TCP by default."""
        tcp = self._exchange.six(6) if self._exchange.has_number(6) else None
        self._exchange.answer(self._box.forward(self._exchange.six(0), tcp))

    def _has_inverse_near(self) -> None:
        exchange = self._exchange
        exchange.answer_integer(self._box.has_inverse(exchange.six(0), exchange.six(6)))

    def _is_within_limits(self) -> bool:
        return all(
            joint.limits is None or joint.limits.lower <= q <= joint.limits.upper
            for joint, q in zip(
                self._box.chain.joints, self._exchange.six(0), strict=True
            )
        )
