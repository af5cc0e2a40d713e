"""Functions of Robotiq's URCap. Positions, speeds and forces are 0 … 255."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Annotated, Final, TypeAlias

from tool0.ur.urscript.execution import Thread
from tool0.ur.urscript.functions import Function, function
from tool0.ur.urscript.kinds import AnyValue, Kind, Number
from tool0.ur.urscript.values import Value
from tool0.ur.urscript_errors import ValueProblem

if TYPE_CHECKING:
    from tool0.ur.robotiq.gripper import RobotiqGripper

FULL: Final = 255
_MILLIMETRE: Final = 0.001


def _count(value: Value) -> int:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueProblem("a number from 0 to 255 is needed")
    if not 0 <= value <= FULL:
        raise ValueProblem(f"a number from 0 to {FULL} is needed, not {value}")
    return round(value)


def _percent(value: Value) -> int:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueProblem("a number from 0 to 100 is needed")
    if not 0 <= value <= 100:
        raise ValueProblem(f"a number from 0 to 100 is needed, not {value}")
    return round(value * FULL / 100)


Count: TypeAlias = Annotated[int, Kind("a number from 0 to 255", _count)]
Percent: TypeAlias = Annotated[int, Kind("a number from 0 to 100", _percent)]
_SOCKET: Final = "1"
"""Default of the last argument, which selects a gripper. An arm has only one
gripper."""


def _gripper(thread: Thread) -> RobotiqGripper:
    gripper = thread.box.gripper
    if gripper is None:
        raise ValueProblem(thread.box.why_no_gripper)
    return gripper


async def _command(thread: Thread, command: Callable[[RobotiqGripper], object]) -> None:
    """Send a command to the gripper and wait for one control period.

    The wait prevents loops of commands from flooding the bring-up with finger motions.
    """
    command(_gripper(thread))
    await thread.box.next_update()


def _count_of(thread: Thread, millimetres: float) -> int:
    """Return the position count for an opening [mm]."""
    counts = _gripper(thread).counts
    opening = millimetres * _MILLIMETRE
    return min(range(FULL + 1), key=lambda count: abs(counts.opening(count) - opening))


async def rq_reset(thread: Thread, gripper_socket: AnyValue = _SOCKET) -> None:
    """Deactivate the gripper."""
    await _command(thread, lambda gripper: gripper.reset())


async def rq_activate(thread: Thread, gripper_socket: AnyValue = _SOCKET) -> None:
    """Start the activation of the gripper."""
    await _command(thread, lambda gripper: gripper.activate())


async def rq_activate_and_wait(
    thread: Thread, gripper_socket: AnyValue = _SOCKET
) -> None:
    """Activate the gripper and wait until the activation is complete."""
    await _gripper(thread).activate_and_wait()


async def rq_open(thread: Thread, gripper_socket: AnyValue = _SOCKET) -> None:
    """Start to open the gripper."""
    await _command(thread, lambda gripper: gripper.move(0))


async def rq_close(thread: Thread, gripper_socket: AnyValue = _SOCKET) -> None:
    """Start to close the gripper."""
    await _command(thread, lambda gripper: gripper.move(FULL))


async def rq_open_and_wait(thread: Thread, gripper_socket: AnyValue = _SOCKET) -> None:
    """Open the gripper and wait until the motion is complete."""
    await _gripper(thread).move_and_wait(0)


async def rq_close_and_wait(thread: Thread, gripper_socket: AnyValue = _SOCKET) -> None:
    """Close the gripper and wait until it is closed or grips an object."""
    await _gripper(thread).move_and_wait(FULL)


async def rq_move(
    thread: Thread, pos: Count, gripper_socket: AnyValue = _SOCKET
) -> None:
    """Start a motion to a position: 0 is open, 255 is closed."""
    await _command(thread, lambda gripper: gripper.move(pos))


async def rq_move_and_wait(
    thread: Thread, pos: Count, gripper_socket: AnyValue = _SOCKET
) -> None:
    """Move to a position and wait until the motion is complete."""
    await _gripper(thread).move_and_wait(pos)


async def rq_move_mm(
    thread: Thread, pos: Number, gripper_socket: AnyValue = _SOCKET
) -> None:
    """Start a motion to an opening [mm]."""
    await _command(thread, lambda gripper: gripper.move(_count_of(thread, pos)))


async def rq_move_and_wait_mm(
    thread: Thread, pos: Number, gripper_socket: AnyValue = _SOCKET
) -> None:
    """Move to an opening [mm] and wait until the motion is complete."""
    await _gripper(thread).move_and_wait(_count_of(thread, pos))


async def rq_set_pos(
    thread: Thread, pos: Count, gripper_socket: AnyValue = _SOCKET
) -> None:
    """Set the requested position of the fingers."""
    await _command(thread, lambda gripper: gripper.change(position=pos))


async def rq_set_speed(
    thread: Thread, speed: Count, gripper_socket: AnyValue = _SOCKET
) -> None:
    """Set the speed of the following motions."""
    await _command(thread, lambda gripper: gripper.change(speed=speed))


async def rq_set_force(
    thread: Thread, force: Count, gripper_socket: AnyValue = _SOCKET
) -> None:
    """Set the force of the following motions."""
    await _command(thread, lambda gripper: gripper.change(force=force))


async def rq_set_speed_norm(
    thread: Thread, speed: Percent, gripper_socket: AnyValue = _SOCKET
) -> None:
    """Set the speed of the following motions [%]."""
    await _command(thread, lambda gripper: gripper.change(speed=speed))


async def rq_set_force_norm(
    thread: Thread, force: Percent, gripper_socket: AnyValue = _SOCKET
) -> None:
    """Set the force of the following motions [%]."""
    await _command(thread, lambda gripper: gripper.change(force=force))


async def rq_go_to(thread: Thread, gripper_socket: AnyValue = _SOCKET) -> None:
    """Start a motion to the requested position."""
    await _command(thread, lambda gripper: gripper.change(go_to=True))


async def rq_stop(thread: Thread, gripper_socket: AnyValue = _SOCKET) -> None:
    """Stop the fingers."""
    await _command(thread, lambda gripper: gripper.stop())


async def rq_wait(thread: Thread, gripper_socket: AnyValue = _SOCKET) -> None:
    """Wait until the motion of the fingers is complete."""
    await _gripper(thread).wait()


def rq_current_pos(thread: Thread, gripper_socket: AnyValue = _SOCKET) -> int:
    """Return the measured position: 0 is open, 255 is closed."""
    return _gripper(thread).position


def rq_current_pos_mm(thread: Thread, gripper_socket: AnyValue = _SOCKET) -> float:
    """Return the measured opening [mm]."""
    gripper = _gripper(thread)
    return gripper.counts.opening(gripper.position) / _MILLIMETRE


def rq_is_gripper_activated(thread: Thread, gripper_socket: AnyValue = _SOCKET) -> bool:
    """Return whether the activation of the gripper is complete."""
    return _gripper(thread).is_activated


def rq_is_motion_complete(thread: Thread, gripper_socket: AnyValue = _SOCKET) -> bool:
    """Return whether the fingers have reached their goal or met an object."""
    return _gripper(thread).is_motion_complete


def rq_is_object_detected(thread: Thread, gripper_socket: AnyValue = _SOCKET) -> bool:
    """Return whether an object has stopped the fingers."""
    return _gripper(thread).is_object_detected


async def rq_auto_release_open_and_wait(
    thread: Thread, gripper_socket: AnyValue = _SOCKET
) -> None:
    """Open slowly, as in an emergency; a reset is necessary afterwards."""
    await _gripper(thread).release_and_wait(opening=True)


async def rq_auto_release_close_and_wait(
    thread: Thread, gripper_socket: AnyValue = _SOCKET
) -> None:
    """Close slowly, as in an emergency; a reset is necessary afterwards."""
    await _gripper(thread).release_and_wait(opening=False)


_PHYSICAL: Final[tuple[Callable[..., Awaitable[None]], ...]] = (
    *(rq_activate_and_wait, rq_open_and_wait, rq_close_and_wait, rq_move_and_wait),
    *(rq_move_and_wait_mm, rq_wait, rq_auto_release_open_and_wait),
    rq_auto_release_close_and_wait,
)
FUNCTIONS: Final[tuple[Function, ...]] = (
    *(function(item, physical=True) for item in _PHYSICAL),
    *(function(item) for item in (rq_reset, rq_activate, rq_open, rq_close, rq_move)),
    *(function(item) for item in (rq_move_mm, rq_set_pos, rq_set_speed, rq_set_force)),
    *(function(item) for item in (rq_set_speed_norm, rq_set_force_norm, rq_go_to)),
    *(function(item) for item in (rq_stop, rq_current_pos, rq_current_pos_mm)),
    *(function(item) for item in (rq_is_gripper_activated, rq_is_motion_complete)),
    function(rq_is_object_detected),
    function(rq_current_pos, "rq_get_position"),
    function(rq_activate_and_wait, "rq_activate_all_grippers", physical=True),
)
