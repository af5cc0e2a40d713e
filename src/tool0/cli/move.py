"""``tool0 move``: joints or the tool of a running bringup to a place."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from tool0.cli.connection import Bringup, wait_for_goal
from tool0.cli.parsing import joint_values, parse
from tool0.description.transform import Pose
from tool0.errors import ConfigError, ControlError, did_you_mean

if TYPE_CHECKING:
    from tool0.api.controller import GoalHandle

SixNumbers = tuple[float, float, float, float, float, float]

_DEFAULT = Bringup()


def run(command: str, arguments: list[str]) -> int:
    """Run the command and return its exit status."""
    return parse(move, command, arguments)


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
    bringup: Bringup = _DEFAULT,
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
