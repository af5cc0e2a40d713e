"""A straight-line motion of a tool for a trajectory controller."""

from __future__ import annotations

import numpy as np

from tool0.errors import ControlError, UnreachableError
from tool0.kinematics.chain import Array
from tool0.kinematics.inverse import InverseKinematics
from tool0.motion.moves import Move, MoveError, pose_numbers
from tool0.motion.path import Path
from tool0.motion.planner import MovePlanner
from tool0.motion.rules import trajectory_rules


def plan_line(
    kinematics: InverseKinematics,
    start: Array,
    T_base_end: Array,
    T_tip_tool: Array,
    *,
    T_root_base: Array,
    speed: float,
    acceleration: float,
    angular_speed: float,
) -> Path:
    """Return the motion of a tool along a straight line from rest to rest.

    Args:
        kinematics: The arm's kinematics.
        start: Joint positions at the start [rad], shape (6,).
        T_base_end: Pose of the tool at the end, shape (4, 4).
        T_tip_tool: Pose of the tool in the flange's frame, shape (4, 4).
        T_root_base: Pose of the arm's base link in the root frame, for error messages,
            shape (4, 4).
        speed: Maximum speed of the tool [m/s].
        acceleration: Maximum acceleration of the tool [m/s²]; a rotation accelerates
            over the same duration.
        angular_speed: Maximum angular speed of the tool [rad/s].

    Raises:
        UnreachableError: If the arm cannot follow the line; the message states the
            reason and the place.
        ControlError: If the line has no length.
    """
    planner = MovePlanner(
        kinematics,
        pose_numbers(T_tip_tool),
        np.asarray(np.linalg.inv(T_root_base)),
        rules=trajectory_rules(kinematics.chain.joints),
    )
    move = Move(
        kind="linear",
        pose=pose_numbers(T_root_base @ T_base_end),
        a=acceleration,
        v=speed,
        w=angular_speed,
    )
    try:
        path = planner.plan(start, [move]).path
    except MoveError as error:
        raise UnreachableError(error.reason) from None
    if path.duration == 0.0:
        raise ControlError("the tool is already there: the line has no length")
    return path
