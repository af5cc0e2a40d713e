"""``tool0 move`` and ``tool0 grip``: motions of a running bringup."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from tool0.cli import INTERRUPTED
from tool0.cli.connection import (
    DEFAULT,
    Bringup,
    Outcome,
    chosen_gripper,
    chosen_robot,
    wait_for_goal,
)
from tool0.cli.parameters import AsJson, Option, joint_values
from tool0.cli.text import grasp_text, print_json
from tool0.description.model import FLANGE, JointType
from tool0.description.transform import Pose
from tool0.description.units import (
    ANGLE,
    LENGTH,
    Metres,
    Quantity,
    Radians,
    read_number,
)
from tool0.errors import ConfigError, GoalTimeoutError

if TYPE_CHECKING:
    from tool0.api.controller import GoalHandle
    from tool0.api.robot import Robot

ToolPose = Annotated[
    tuple[Metres, Metres, Metres, Radians, Radians, Radians],
    Option(metavar="X Y Z ROLL PITCH YAW"),
]
JointTargets = Annotated[tuple[str, ...], Option(metavar="JOINT=VALUE ...")]

_SETTLE = 1.0
"""Longest wait, after a goal has ended, for the pads to stand still [wall s]."""


def move(
    *,
    joints: JointTargets = (),
    duration: float | None = None,
    controller: str | None = None,
    pose: ToolPose | None = None,
    linear: bool = False,
    speed: float | None = None,
    tip: str | None = None,
    relative_to: str | None = None,
    robot: str | None = None,
    timeout: float | None = None,
    as_json: AsJson = False,
    bringup: Bringup = DEFAULT,
) -> int:
    """Move joints, or the tool to a pose, and wait until the motion has ended.

    Give either --joints or --pose.  Ctrl-C stops the robot.

    Args:
        joints: Target positions [rad | m]; other joints stay where they are.
        duration: Duration of a motion with --joints, in simulated time [s]; 2 if not
            given.
        controller: Trajectory controller to use; if not given, the one that drives the
            joints.
        pose: Target pose of the tool [m, rad].
        linear: Move the tool along a straight line.
        speed: Speed of a motion with --pose: a fraction of the joints' velocity limits,
            0.01 to 1; with --linear, the speed of the tool [m/s].
        tip: Link that moves to --pose; tool0 if not given.
        relative_to: Link in whose frame --pose is given; the root if not given.
        robot: Which robot of a cell moves to --pose; with --joints, whose joints they
            are, so that you leave out their prefix.
        timeout: Cancel the motion after this wall time [s].
        as_json: Print one JSON object.
    """
    of_pose: dict[str, Any] = {  # values of two types
        "speed": speed,
        "tip": tip,
        "relative_to": relative_to,
    }
    if (pose is None) == (not joints):
        raise ConfigError("give either --joints or --pose")
    if pose is None:
        _refuse("--pose", {**of_pose, "linear": linear or None})
        duration = 2.0 if duration is None else duration
        outcome = _move_joints(
            joints,
            duration,
            controller=controller,
            robot=robot,
            timeout=timeout,
            bringup=bringup,
        )
        return _finish(outcome, as_json=as_json)
    _refuse("--joints", {"duration": duration, "controller": controller})
    given = {name: value for name, value in of_pose.items() if value is not None}
    x, y, z, roll, pitch, yaw = pose
    target = Pose(xyz=(x, y, z), rpy=(roll, pitch, yaw))
    with bringup.connect() as connected:
        arm = chosen_robot(connected, robot)
        move = arm.move_linear if linear else arm.move_to
        outcome = wait_for_goal(connected, partial(move, target, **given), timeout)
    return _finish(outcome, as_json=as_json)


def _finish(outcome: Outcome, *, as_json: bool) -> int:
    """Print an outcome; return the exit status."""
    if as_json:
        print_json(outcome.as_json())
    else:
        print(outcome)
    return outcome.status


def _refuse(other: str, options: Mapping[str, object]) -> None:
    """Raise ConfigError if an option was given that belongs to ``other``."""
    for name, value in options.items():
        if value is not None:
            raise ConfigError(f"--{name.replace('_', '-')} needs {other}")


def _move_joints(
    joints: tuple[str, ...],
    duration: float,
    *,
    controller: str | None,
    robot: str | None,
    timeout: float | None,
    bringup: Bringup,
) -> Outcome:
    given, given_units = joint_values(joints)
    if not 0.0 < duration < math.inf:
        raise ConfigError(f"--duration must be above 0 s, got {duration}")
    with bringup.connect() as connected:
        prefix = ""
        if robot is not None:
            prefix = chosen_robot(connected, robot).tip.removesuffix(FLANGE)
        positions = {prefix + name: value for name, value in given.items()}
        units = {prefix + name: unit for name, unit in given_units.items()}
        _check_units(units, connected)

        def start() -> GoalHandle:
            if controller is not None:
                handle = connected.controller(controller)
                return handle.move(positions, duration=duration)
            return connected.move_joints(positions, duration=duration)[0]

        return wait_for_goal(connected, start, timeout)


def _check_units(units: Mapping[str, Quantity], robot: Robot) -> None:
    """Raise ConfigError if an angle is meant for a sliding joint, or the reverse."""
    joints = robot.description.model.joint_by_name if units else {}
    for name, quantity in units.items():
        if name not in joints:
            continue
        needed = LENGTH if joints[name].type is JointType.PRISMATIC else ANGLE
        if quantity is not needed:
            raise ConfigError(
                f"--joints: the unit of '{name}' is {' or '.join(needed.units)}, not "
                f"{' or '.join(quantity.units)}"
            )


def grip(
    *,
    opening: Metres | None = None,
    position: Annotated[str, Option(metavar="ANGLE | LENGTH")] | None = None,
    speed: float | None = None,
    force: float | None = None,
    effort: float | None = None,
    robot: str | None = None,
    timeout: float | None = None,
    as_json: AsJson = False,
    bringup: Bringup = DEFAULT,
) -> int:
    """Open or close the gripper, wait, and report what it holds.

    Give either --opening or --position.  Ctrl-C stops the gripper.

    Args:
        opening: Distance between the pads [m]; 0 is closed.
        position: Position of the driven joint, instead of --opening: an angle, or a
            length if it slides; 0 is open.
        speed: Speed of the pads relative to each other [m/s]; the fastest if not given.
        force: Largest force at each pad [N]; the strongest if not given.
        effort: Largest effort of the driven joint [N·m], [N] if it slides, instead of
            --force.
        robot: Which robot of a cell has the gripper.
        timeout: Cancel the motion after this wall time [s].
        as_json: Print one JSON object.
    """
    if (opening is None) == (position is None):
        raise ConfigError("give either --opening or --position")
    with bringup.connect() as connected:
        gripper = chosen_gripper(connected, robot)
        move = partial(
            gripper.move,
            opening=opening,
            position=_joint_position(position, gripper.geometry.quantity),
            speed=speed,
            force=force,
            effort=effort,
        )
        outcome = wait_for_goal(connected, move, timeout)
        if not as_json:
            print(outcome, flush=True)
        if outcome.status != INTERRUPTED:
            with contextlib.suppress(GoalTimeoutError):
                gripper.wait(_SETTLE)
        state = gripper.state
    if as_json:
        grasp = {**asdict(state), "gobj": state.gobj}
        print_json({**outcome.as_json(), "gripper": grasp})
    elif outcome.status != INTERRUPTED:
        print(grasp_text(state))
    return outcome.status


def _joint_position(text: str | None, quantity: Quantity) -> float | None:
    """Return ``--position`` [rad | m]: the joint measures ``quantity``."""
    if text is None:
        return None
    try:
        return read_number(text, quantity)[0]
    except ConfigError as error:
        raise ConfigError(f"--position: {error}") from None
