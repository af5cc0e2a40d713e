"""Functions of URScript's module motion: moves, servo, speed and stop functions.

In joint moves, a [rad/s²] and v [rad/s] are the limits of the leading joint. In tool
moves, a [m/s²] and v [m/s] are the limits of the TCP.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from typing import Final

from tool0.errors import UnreachableError
from tool0.protocol.control_box import MOST_REASON, StopProtectively
from tool0.protocol.state import Six
from tool0.ur.urscript.execution import Thread
from tool0.ur.urscript.functions import Function, function
from tool0.ur.urscript.kinds import Integer, Joints, Number, Spatial, Target
from tool0.ur.urscript.values import Pose
from tool0.ur.urscript_errors import ValueProblem

_LOOKAHEAD: Final = (0.03, 0.2)
"""Range of the lookahead time [s]."""
_GAIN: Final = (100.0, 2000.0)
FASTEST_TOOL: Final = (1.0, 2.5)
"""Maximum speed and acceleration of OptiMove's lines [m/s, m/s²]. UR specifies the
speed as the "typical tool speed" of UR arms, but does not specify an acceleration."""


def _joints(thread: Thread, target: Target) -> Six:
    """Return a target's joint positions; for a pose, the ones nearest the setpoint."""
    if not isinstance(target, Pose):
        thread.execution.waypoint = Pose(thread.box.forward(target))
        return target
    thread.execution.waypoint = target
    try:
        return thread.box.inverse(target, thread.box.target_q)
    except UnreachableError as error:
        raise ValueProblem(f"no inverse kinematics solution: {error}") from None


def _pose(thread: Thread, target: Target) -> Sequence[float]:
    """Return the TCP's pose for a target that is a pose or joint positions."""
    pose = target if isinstance(target, Pose) else Pose(thread.box.forward(target))
    thread.execution.waypoint = pose
    return pose


def _check(a: float, v: float, t: float = 0.0, r: float = 0.0) -> None:
    """Raise ValueProblem for values that are invalid in all motions."""
    if t < 0.0 or r < 0.0:
        raise ValueProblem("time and blend radius are not negative")
    if not t and not (a > 0.0 and v > 0.0):
        raise ValueProblem("acceleration and speed are greater than 0")


async def _follow(thread: Thread, motion: Callable[[], Awaitable[None]]) -> None:
    """Execute a motion that follows a path of the tool.

    As on a real robot, a protective stop occurs if the arm cannot follow the path. In
    tool0, the protective stop occurs before the arm moves.
    """
    box = thread.box
    try:
        await thread.moving(motion)
    except UnreachableError as error:
        await box.call(StopProtectively(arm=box.arm, reason=str(error)[:MOST_REASON]))
        await box.until(lambda: bool(box.stopped))
        raise


async def movej(
    thread: Thread,
    q: Target,
    a: Number = 1.4,
    v: Number = 1.05,
    t: Number = 0,
    r: Number = 0,
) -> None:
    """Move along a straight line in joint space."""
    _check(a, v, t, r)
    goal = _joints(thread, q)
    await thread.moving(
        lambda: thread.execution.abortable(thread.moves.movej(goal, a, v, t, r))
    )


async def optimovej(
    thread: Thread, q: Target, a: Number = 0.3, v: Number = 0.3, r: Number = 0
) -> None:
    """Move in joint space; a and v are fractions of the joint limits."""
    joints = thread.box.chain.joints
    acceleration = _fraction("a", a) * min(item.max_acceleration for item in joints)
    speed = _fraction("v", v) * min(item.max_velocity for item in joints)
    await movej(thread, q, acceleration, speed, 0, r)


async def optimovel(
    thread: Thread, pose: Target, a: Number = 0.3, v: Number = 0.3, r: Number = 0
) -> None:
    """Move the TCP along a line; a and v are fractions of ``FASTEST_TOOL``."""
    acceleration = _fraction("a", a) * FASTEST_TOOL[1]
    await movel(thread, pose, acceleration, _fraction("v", v) * FASTEST_TOOL[0], 0, r)


def _fraction(name: str, value: float) -> float:
    if not 0.0 < value <= 1.0:
        raise ValueProblem(f"{name} is {value}; it is above 0 and at most 1")
    return value


async def movel(
    thread: Thread,
    pose: Target,
    a: Number = 1.2,
    v: Number = 0.25,
    t: Number = 0,
    r: Number = 0,
) -> None:
    """Move the TCP along a straight line."""
    _check(a, v, t, r)
    goal = _pose(thread, pose)
    await _follow(
        thread,
        lambda: thread.execution.abortable(thread.moves.movel(goal, a, v, t, r)),
    )


async def movep(
    thread: Thread, pose: Target, a: Number = 1.2, v: Number = 0.25, r: Number = 0
) -> None:
    """Move the TCP at constant speed with circular blends."""
    _check(a, v, 0.0, r)
    goal = _pose(thread, pose)
    await _follow(thread, lambda: thread.moves.movep(goal, a, v, r))


async def movec(
    thread: Thread,
    pose_via: Target,
    pose_to: Target,
    a: Number = 1.2,
    v: Number = 0.25,
    r: Number = 0,
    mode: Integer = 0,
) -> None:
    """Move the TCP along an arc; mode 1 fixes the TCP's orientation to the arc."""
    _check(a, v, 0.0, r)
    if mode not in {0, 1}:
        raise ValueProblem(f"mode is {mode}; it can be 0 or 1")
    via, goal = _pose(thread, pose_via), _pose(thread, pose_to)
    await _follow(thread, lambda: thread.moves.movec(via, goal, a, v, r, mode))


async def servoj(
    thread: Thread,
    q: Joints,
    a: Number = 0,
    v: Number = 0,
    t: Number = 0.002,
    lookahead_time: Number = 0.1,
    gain: Number = 300,
) -> None:
    """Follow a stream of joint positions; a and v are not used."""
    del a, v
    if t < 0.0:
        raise ValueProblem("the time is not negative")
    lookahead = min(max(lookahead_time, _LOOKAHEAD[0]), _LOOKAHEAD[1])
    stiffness = min(max(gain, _GAIN[0]), _GAIN[1])
    await thread.moving(lambda: thread.moves.servoj(q, t, lookahead, stiffness))


async def servoc(
    thread: Thread, pose: Target, a: Number = 1.2, v: Number = 0.25, r: Number = 0
) -> None:
    """Follow a stream of TCP poses along circular arcs."""
    _check(a, v, 0.0, r)
    goal = _pose(thread, pose)
    await _follow(thread, lambda: thread.moves.servoc(goal, a, v, r))


async def speedj(
    thread: Thread, qd: Joints, a: Number = 1.4, t: Number | None = None
) -> None:
    """Accelerate to joint velocities; return after t, or when they are reached."""
    await thread.moving(lambda: thread.moves.speedj(qd, a, t))


async def speedl(
    thread: Thread,
    xd: Spatial,
    a: Number = 1.2,
    t: Number | None = None,
    aRot: Number | None = None,
) -> None:
    """Accelerate to a TCP velocity; return after t, or when it is reached."""
    await thread.moving(lambda: thread.moves.speedl(xd, a, t, aRot))


async def stopj(thread: Thread, a: Number = 2.0) -> None:
    """Decelerate the joints to rest."""
    await thread.moving(lambda: thread.moves.stopj(a))


async def stopl(thread: Thread, a: Number = 20.0, aRot: Number | None = None) -> None:
    """Decelerate the TCP to rest."""
    await thread.moving(lambda: thread.moves.stopl(a, aRot))


def motion_version_set(thread: Thread, version: Integer) -> None:
    """Accept version 1 or 2 of movej and movel; both versions are the same."""
    if version not in {1, 2}:
        raise ValueProblem(f"version is {version}; it can be 1 or 2")
    thread.execution.motion_version = version


def motion_version_get(thread: Thread) -> int:
    """Return the version that was set; 1 if no version was set."""
    return thread.execution.motion_version


FUNCTIONS: Final[tuple[Function, ...]] = (
    *(
        function(item, physical=True)
        for item in (
            *(movej, movel, movep, movec, servoj, servoc, speedj, speedl, stopj, stopl),
            *(optimovej, optimovel),
        )
    ),
    *(function(item) for item in (motion_version_get, motion_version_set)),
)
