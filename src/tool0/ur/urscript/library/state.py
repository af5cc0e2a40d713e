"""Functions for the state of the arm; poses are in the base frame."""

from __future__ import annotations

import math
from typing import Final

from tool0.errors import UnreachableError
from tool0.ur.urscript.execution import Thread
from tool0.ur.urscript.functions import Function, function
from tool0.ur.urscript.kinds import Integer, Joints, Number, PoseLike, Spatial, Target
from tool0.ur.urscript.values import Pose, Value
from tool0.ur.urscript_errors import ValueProblem

_AT_FLANGE: Final = (0.0,) * 6


def get_actual_joint_positions(thread: Thread) -> Value:
    """Return the measured joint positions [rad]."""
    return thread.box.q


def get_actual_joint_positions_history(thread: Thread, steps: Integer = 0) -> Value:
    """Return the measured joint positions ``steps`` control periods ago [rad]."""
    return thread.execution.history.positions(steps)


def get_actual_joint_speeds(thread: Thread) -> Value:
    """Return the measured joint velocities [rad/s]."""
    return thread.box.qd


def get_actual_joint_accelerations(thread: Thread) -> Value:
    """Return the change of the measured velocities in one control period [rad/s²]."""
    return thread.execution.history.accelerations()


def get_target_joint_positions(thread: Thread) -> Value:
    """Return the setpoint of the joint positions [rad]."""
    return thread.box.target_q


def get_target_joint_speeds(thread: Thread) -> Value:
    """Return the setpoint of the joint velocities [rad/s]."""
    return thread.box.target_qd


def get_target_joint_accelerations(thread: Thread) -> Value:
    """Return the setpoint of the joint accelerations [rad/s²]."""
    return thread.box.target_qdd


def get_actual_tcp_pose(thread: Thread) -> Value:
    """Return the measured pose of the TCP."""
    return Pose(thread.box.tcp_pose())


def get_target_tcp_pose(thread: Thread) -> Value:
    """Return the setpoint of the TCP's pose."""
    return Pose(thread.box.tcp_pose(target=True))


def get_target_waypoint(thread: Thread) -> Value:
    """Return the target of the last move; the TCP's setpoint before the first move."""
    return thread.execution.waypoint or get_target_tcp_pose(thread)


def get_actual_tcp_speed(thread: Thread) -> Value:
    """Return the measured velocity of the TCP [m/s, rad/s]."""
    return Pose(thread.box.tcp_speed())


def get_target_tcp_speed(thread: Thread) -> Value:
    """Return the setpoint of the TCP's velocity [m/s, rad/s]."""
    return Pose(thread.box.tcp_speed(target=True))


def get_actual_tool_flange_pose(thread: Thread) -> Value:
    """Return the measured pose of the flange."""
    return Pose(thread.box.forward(thread.box.q, _AT_FLANGE))


def get_tcp_offset(thread: Thread) -> Value:
    """Return the pose of the TCP in the flange's frame."""
    return Pose(thread.box.tcp)


def get_tcp_force(thread: Thread) -> Value:
    """Return the external wrench at the flange in the base frame's axes [N, N·m]."""
    force, torque = thread.box.flange_wrench()
    return Pose([*force, *torque])


def force(thread: Thread) -> float:
    """Return the magnitude of the external force at the flange [N]."""
    force, _ = thread.box.flange_wrench()
    return math.hypot(*force)


def get_joint_torques(thread: Thread) -> Value:
    """Return the joint torques that the external wrench causes [N·m]."""
    return thread.box.posture().efforts(*thread.box.flange_wrench())


def get_forward_kin(
    thread: Thread, q: Joints | None = None, tcp: PoseLike | None = None
) -> Value:
    """Return the TCP's pose at joint positions (by default, the measured ones)."""
    return Pose(thread.box.forward(thread.box.q if q is None else q, tcp))


def get_inverse_kin(
    thread: Thread,
    x: PoseLike,
    qnear: Joints | None = None,
    maxPositionError: Number = 1e-10,
    maxOrientationError: Number = 1e-10,
    tcp: PoseLike | None = None,
) -> Value:
    """Return the solution nearest to qnear (by default, the measured positions)."""
    del maxPositionError, maxOrientationError  # the solutions are exact
    near = thread.box.q if qnear is None else qnear
    try:
        return thread.box.inverse(x, near, tcp)
    except UnreachableError as error:
        raise ValueProblem(f"no inverse kinematics solution: {error}") from None


def get_inverse_kin_has_solution(
    thread: Thread,
    pose: PoseLike,
    qnear: Joints | None = None,
    maxPositionError: Number = 1e-10,
    maxOrientationError: Number = 1e-10,
    tcp: PoseLike | None = None,
) -> bool:
    """Return whether get_inverse_kin finds a solution."""
    try:
        get_inverse_kin(thread, pose, qnear, maxPositionError, maxOrientationError, tcp)
    except ValueProblem:
        return False
    return True


def is_within_safety_limits(
    thread: Thread, position: Target, qNear: Joints | None = None
) -> bool:
    """Return whether the arm can reach a pose or joint positions."""
    if isinstance(position, Pose):
        return get_inverse_kin_has_solution(thread, position, qNear)
    limits = [joint.limits for joint in thread.box.chain.joints]
    return all(
        limit.lower <= x <= limit.upper
        for x, limit in zip(position, limits, strict=True)
    )


def is_steady(thread: Thread) -> bool:
    """Return whether the arm has been at rest for 0.5 s."""
    return thread.execution.history.is_steady()


def tool_contact(thread: Thread, direction: Spatial | None = None) -> Value:
    """Return the number of control periods since a tool contact started, or 0.

    The direction is that of the motion, in the base frame; zeros stand for any
    direction. If the direction is omitted, the velocity of the TCP is used.
    """
    motion = thread.box.tcp_speed() if direction is None else direction
    return thread.execution.history.contact(motion)


FUNCTIONS: Final[tuple[Function, ...]] = (
    *(
        function(item)
        for item in (
            get_actual_joint_accelerations,
            *(force, get_actual_joint_positions, get_actual_joint_positions_history),
            *(get_actual_joint_speeds, get_actual_tcp_pose, get_actual_tcp_speed),
            *(get_actual_tool_flange_pose, get_joint_torques),
            *(get_target_joint_accelerations, get_target_joint_positions),
            get_target_joint_speeds,
            *(get_target_tcp_pose, get_target_tcp_speed, get_tcp_force),
            get_target_waypoint,
            *(get_tcp_offset, is_steady, tool_contact),
        )
    ),
    function(get_forward_kin, cost=4),
    *(
        function(item, cost=140)
        for item in (
            *(get_inverse_kin, get_inverse_kin_has_solution, is_within_safety_limits),
        )
    ),
    function(get_actual_joint_positions, "get_joint_positions"),
    function(get_actual_tcp_pose, "tool_pose"),  # used by PolyScope's force nodes
    function(get_target_tcp_pose, "get_target_tcp_pose_along_path"),
    function(get_target_tcp_speed, "get_target_tcp_speed_along_path"),
)
