"""``tool0 move`` and ``tool0 grip``: motions of a running bringup."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from tool0.cli import INTERRUPTED
from tool0.cli.connection import DEFAULT, Bringup, wait_for_goal
from tool0.cli.parsing import joint_values
from tool0.description.transform import Pose
from tool0.errors import ConfigError, ControlError, GoalTimeoutError, did_you_mean

if TYPE_CHECKING:
    from tool0.api.controller import GoalHandle
    from tool0.sensing.grasp import GraspState

SixNumbers = tuple[float, float, float, float, float, float]

_SETTLE = 1.0
"""Longest wait, after a goal has ended, for the pads to stand still [wall s]."""


def move(
    *,
    joints: tuple[str, ...] = (),
    duration: float | None = None,
    controller: str | None = None,
    pose: SixNumbers | None = None,
    linear: bool = False,
    speed: float | None = None,
    tip: str | None = None,
    relative_to: str | None = None,
    arm: str | None = None,
    timeout: float | None = None,
    bringup: Bringup = DEFAULT,
) -> int:
    """Move joints or the tool, and wait until they are there; Ctrl-C stops the robot.

    Give either --joints or --pose.

    Args:
        joints: joint=position … [rad]; joints not given keep their place.
        duration: How long the motion of --joints takes [simulated s]; 2 if left out.
        controller: A trajectory controller; found by the --joints if left out.
        pose: X Y Z ROLL PITCH YAW, where the tool is to be [m, rad], in the root.
        linear: Take the tool to --pose along a straight line.
        speed: On the way to --pose: part of the joints' largest velocities, 0.01 to 1;
            with --linear that of the tool [m/s].
        tip: The link that is to be at --pose; tool0 if left out.
        relative_to: The link in whose frame --pose is, as tool0; the root if left out.
        arm: The arm, where the robot has several.
        timeout: Stop the motion after so many wall seconds.
        bringup: Which bringup.
    """
    of_pose: dict[str, Any] = {  # values of two types
        "speed": speed,
        "tip": tip,
        "relative_to": relative_to,
    }
    if (pose is None) == (not joints):
        raise ConfigError("give either --joints, joint=position …, or --pose")
    if pose is None:
        _refuse("--pose", {**of_pose, "arm": arm, "linear": linear or None})
        duration = 2.0 if duration is None else duration
        return _move_joints(joints, duration, controller, timeout, bringup)
    _refuse("--joints", {"duration": duration, "controller": controller})
    given = {name: value for name, value in of_pose.items() if value is not None}
    x, y, z, roll, pitch, yaw = pose
    target = Pose(xyz=(x, y, z), rpy=(roll, pitch, yaw))
    with bringup.connect() as robot:
        chosen = robot.arms.get(arm) if arm is not None else robot.arm
        if chosen is None:
            raise ControlError(f"no arm '{arm}'{did_you_mean(arm or '', robot.arms)}")
        move = chosen.move_linear if linear else chosen.move_to
        return wait_for_goal(robot, partial(move, target, **given), timeout)


def _refuse(other: str, options: Mapping[str, object]) -> None:
    """Raise ConfigError if an option was given that belongs to ``other``."""
    for name, value in options.items():
        if value is not None:
            raise ConfigError(f"--{name.replace('_', '-')} goes with {other}")


def _move_joints(
    joints: tuple[str, ...],
    duration: float,
    controller: str | None,
    timeout: float | None,
    bringup: Bringup,
) -> int:
    positions = joint_values(joints, "--joints")
    if not 0.0 < duration < math.inf:
        raise ConfigError(f"--duration must be above 0 s, got {duration}")
    with bringup.connect() as robot:

        def start() -> GoalHandle:
            if controller is not None:
                handle = robot.controller(controller)
                return handle.move(positions, duration=duration)
            return robot.move_joints(positions, duration=duration)[0]

        return wait_for_goal(robot, start, timeout)


def grip(
    *,
    opening: float | None = None,
    position: float | None = None,
    speed: float | None = None,
    force: float | None = None,
    effort: float | None = None,
    timeout: float | None = None,
    bringup: Bringup = DEFAULT,
) -> int:
    """Open or close the gripper, wait, and tell what it holds; Ctrl-C stops it.

    Args:
        opening: Distance between the pads [m]; 0 is closed.
        position: Instead of that, the position of the driven joint [rad].
        speed: Of the pads towards each other [m/s]; 0.02 to 0.15 for a 2F-85.
        force: Largest force at each pad [N]; 20 to 235 for a 2F-85.
        effort: Instead of that, the largest torque at the driven joint [N·m].
        timeout: Stop after so many wall seconds.
        bringup: Which bringup.
    """
    if (opening is None) == (position is None):
        raise ConfigError("give either --opening [m] or --position [rad]")
    with bringup.connect() as robot:
        move = partial(
            robot.gripper.move,
            opening=opening,
            position=position,
            speed=speed,
            force=force,
            effort=effort,
        )
        status = wait_for_goal(robot, move, timeout)
        if status != INTERRUPTED:
            with contextlib.suppress(GoalTimeoutError):
                robot.gripper.wait(_SETTLE)
            print(described(robot.gripper.state))
    return status


def described(state: GraspState) -> str:
    """Return what a gripper does, for people, with Robotiq's number for it."""
    opening = f"{1e3 * state.opening:.1f} mm"
    words = {
        "holding_inside": f"holds something {opening} wide",
        "holding_outside": f"presses against something outside, open {opening}",
        "at_target": f"open {opening}",
        "moving": f"moving, open {opening}",
    }
    if state.motion not in words:
        return f"open {opening}, commanded by nobody"
    return f"{words[state.motion]} (gOBJ {state.gobj})"
