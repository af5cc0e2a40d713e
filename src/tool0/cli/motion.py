"""``tool0 move`` and ``tool0 grip``: motions of a running bringup."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping
from dataclasses import asdict
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from tool0.cli import GOAL_FAILED, INTERRUPTED, OK
from tool0.cli.connection import (
    DEFAULT,
    Bringup,
    Outcome,
    chosen_gripper,
    chosen_robot,
    wait_for_goal,
    wait_for_goals,
)
from tool0.cli.parameters import AsJson, Option, joint_values
from tool0.cli.text import counted, grasp_text, print_json
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
from tool0.errors import (
    CollisionError,
    ConfigError,
    GoalTimeoutError,
    PlanningError,
)
from tool0.protocol.request import CollisionRule

if TYPE_CHECKING:
    from tool0.api.arm import Arm
    from tool0.api.controller import GoalHandle
    from tool0.api.robot import Robot
    from tool0.cli.outputs import PathOutput, WayOutput
    from tool0.protocol.planning import Checked, Plan

ToolPose = Annotated[
    tuple[Metres, Metres, Metres, Radians, Radians, Radians],
    Option(metavar="X Y Z ROLL PITCH YAW"),
]
JointTargets = Annotated[tuple[str, ...], Option(metavar="JOINT=VALUE ...")]

_SETTLE = 1.0
"""Longest wait for the pads to come to rest after a goal has ended [wall s]."""


def move(
    *,
    joints: JointTargets = (),
    duration: float | None = None,
    controller: str | None = None,
    pose: ToolPose | None = None,
    linear: bool = False,
    speed: float | None = None,
    tip: Annotated[str | None, Option(metavar="LINK")] = None,
    relative_to: Annotated[str | None, Option(metavar="LINK")] = None,
    check: bool = False,
    plan: bool = False,
    clearance: Metres | None = None,
    collision: CollisionRule | None = None,
    robot: str | None = None,
    timeout: float | None = None,
    as_json: AsJson = False,
    bringup: Bringup = DEFAULT,
) -> int:
    """Move joints to positions or the tool to a pose, and wait for the motion to end.

    Give either --joints or --pose.  A motion that would collide is refused; with
    --plan, the motion avoids obstacles.  Ctrl-C stops the robot.

    Args:
        joints: Target positions [rad | m]; the other joints keep their positions.
        duration: Duration of a motion with --joints, in simulated time [s]; the default
            is 2.
        controller: Trajectory controller to use; by default, the controller that drives
            the joints.
        pose: Target pose of the tool [m, rad].
        linear: Move the tool along a straight line.
        speed: Speed of a motion with --pose or --plan, as a fraction of the joints'
            velocity limits, 0.01 to 1.  With --linear, the value is the speed of the
            tool [m/s].
        tip: Link that moves to --pose; the default is `tool0`.
        relative_to: Reference link of --pose; the default is the robot's root.
        check: Do not move; print whether the motion would be free of collisions or,
            with --plan, whether a path around the obstacles exists.  The exit status is
            1 if the answer is no.
        plan: Plan a path around obstacles to any configuration that reaches the target,
            and move along this path.
        clearance: Minimum distance between bodies [m]; the default is 5mm with --plan,
            and 0 with --check alone.
        collision: Refuse a motion that would collide (the default), or ignore
            collisions.
        robot: In a cell, the robot that moves to --pose.  With --joints, the names of
            this robot's joints need no prefix.
        timeout: Cancel the motion after this wall time [s].
        as_json: Print one JSON object.
    """
    if (pose is None) == (not joints):
        raise ConfigError("give either --joints or --pose")
    of_pose = {"tip": tip, "relative_to": relative_to}
    if pose is None:
        _refuse("--pose", {**of_pose, "linear": linear or None})
        if not plan:
            _refuse("--pose or --plan", {"speed": speed})
    else:
        _refuse("--joints", {"duration": duration, "controller": controller})
    if not (check or plan):
        _refuse("--check or --plan", {"clearance": clearance})
    elif collision is not None:
        raise ConfigError("--collision is of a motion without --check and --plan")
    if plan and (linear or duration is not None or controller is not None):
        raise ConfigError("--plan has no --linear, --duration or --controller")
    with bringup.connect() as connected:
        target: Pose | dict[str, float]
        start: Callable[[], GoalHandle]
        if pose is None:
            target = _joint_targets(joints, connected, robot)
        else:
            x, y, z, roll, pitch, yaw = pose
            target = Pose(xyz=(x, y, z), rpy=(roll, pitch, yaw))
        if check or plan:
            arm = _arm_of(target, connected, robot)
            apart = _given(clearance=clearance, **of_pose)
            if not plan:
                checked = arm.check(target, linear=linear, **apart)
                return _show_check(checked, as_json=as_json)
            search = partial(arm.plan, target, **apart, **_given(speed=speed))
            if check:
                return _show_way(search, as_json=as_json)
            found = search()
            if not as_json:
                print(_way_text(found), flush=True)
            start = partial(arm.execute, found)
            outcome = wait_for_goal(connected, start, timeout)
            return _finish(outcome, as_json=as_json, plan=found)
        rule: CollisionRule = collision or "refuse"
        if isinstance(target, Pose):
            arm = chosen_robot(connected, robot)
            move = arm.move_linear if linear else arm.move_to
            options = _given(speed=speed, **of_pose)
            start = partial(move, target, collision=rule, **options)
            outcome = wait_for_goal(connected, start, timeout)
        else:
            joints_start = _joint_motion(connected, target, duration, controller, rule)
            outcome = wait_for_goals(connected, joints_start, timeout)
    return _finish(outcome, as_json=as_json)


def _finish(outcome: Outcome, *, as_json: bool, plan: Plan | None = None) -> int:
    """Print an outcome; return the exit status."""
    if as_json:
        way = {} if plan is None else {"plan": _way_json(plan)}
        print_json({**outcome.as_json(), **way})
    else:
        print(outcome)
    return outcome.status


def _refuse(other: str, options: Mapping[str, object]) -> None:
    """Raise ConfigError if an option is given that applies only to ``other``."""
    for name, value in options.items():
        if value is not None:
            raise ConfigError(f"--{name.replace('_', '-')} needs {other}")


def _given(**options: object) -> dict[str, Any]:
    """Return the options that have values other than None, by name."""
    return {name: value for name, value in options.items() if value is not None}


def _joint_targets(
    joints: tuple[str, ...], connected: Robot, robot: str | None
) -> dict[str, float]:
    """Return ``--joints`` [rad | m], with the prefix of ``--robot``."""
    given, units = joint_values(joints)
    prefix = ""
    if robot is not None:
        prefix = chosen_robot(connected, robot).tip.removesuffix(FLANGE)
    _check_units({prefix + name: unit for name, unit in units.items()}, connected)
    return {prefix + name: value for name, value in given.items()}


def _joint_motion(
    connected: Robot,
    positions: Mapping[str, float],
    duration: float | None,
    controller: str | None,
    collision: CollisionRule,
) -> Callable[[], tuple[GoalHandle, ...]]:
    """Return a function that starts a motion of joints."""
    duration = 2.0 if duration is None else duration
    if not 0.0 < duration < math.inf:
        raise ConfigError(f"--duration must be above 0 s, got {duration}")

    def start() -> tuple[GoalHandle, ...]:
        if controller is not None:
            handle = connected.controller(controller)
            return (handle.move(positions, duration=duration, collision=collision),)
        return connected.move_joints(positions, duration=duration, collision=collision)

    return start


# ---- collisions ----------------------------------------------------------------------


def _arm_of(
    target: Pose | Mapping[str, float], connected: Robot, robot: str | None
) -> Arm:
    """Return the arm to move to a target, selected by ``--robot`` or the joints."""
    if robot is None and not isinstance(target, Pose):
        for arm in connected.arms.values():
            if not target.keys().isdisjoint(arm.joint_names):
                return arm
    return chosen_robot(connected, robot)


def _show_check(found: Checked, *, as_json: bool) -> int:
    """Print whether a motion is free of collisions; return the exit status."""
    from msgspec import to_builtins

    if as_json:
        print_json(to_builtins(found))
    elif found.is_free:
        print("free")
    else:
        print(f"not free: at {found.part:.0%} of the way, {found.reason}")
    return OK if found.is_free else GOAL_FAILED


def _show_way(search: Callable[[], Plan], *, as_json: bool) -> int:
    """Print whether there is a path around obstacles; return the exit status."""
    plan, reason = None, ""
    try:
        plan = search()
    except (CollisionError, PlanningError) as error:
        reason = str(error)
    if as_json:
        path: PathOutput = {"is_free": False, "reason": reason}
        if plan is not None:
            path = {"is_free": True, "plan": _way_json(plan)}
        print_json(path)
    else:
        print(f"not free: {reason}" if plan is None else _way_text(plan))
    return GOAL_FAILED if plan is None else OK


def _way_json(plan: Plan) -> WayOutput:
    return {
        "duration": plan.duration,
        "clearance": plan.clearance,
        "nearest": plan.nearest,
        "is_direct": plan.is_direct,
        "waypoints": len(plan.waypoints),
        "planning_time": plan.planning_time,
    }


def _way_text(plan: Plan) -> str:
    """Return a line of text that describes a plan."""
    turns = len(plan.waypoints) - 2
    way = "straight" if turns == 0 else f"around by {counted(turns, 'waypoint')}"
    apart = "nothing within 1 m"
    if plan.nearest:
        apart = f"{1e3 * plan.clearance:.1f} mm apart: {plan.nearest}"
    return (
        f"{way}, {plan.duration:.2f} s; {apart}; planned in "
        f"{1e3 * plan.planning_time:.0f} ms"
    )


def _check_units(units: Mapping[str, Quantity], robot: Robot) -> None:
    """Raise ConfigError if a value's unit does not match the type of its joint."""
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
    """Open or close the gripper, wait, and report whether it holds an object.

    Give either --opening or --position.  Ctrl-C stops the gripper.

    Args:
        opening: Distance between the pads [m]; the gripper is closed at 0.
        position: Position of the driven joint, instead of --opening: an angle for a
            revolute joint, or a length for a prismatic joint.  The gripper is open at
            0.
        speed: Speed of the pads relative to each other [m/s]; the default is the
            maximum.
        force: Maximum force at each pad [N]; the default is the gripper's maximum.
        effort: Maximum effort of the driven joint, instead of --force: [N·m] for a
            revolute joint, [N] for a prismatic joint.
        robot: In a cell, the robot that has the gripper.
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
    """Return ``--position`` [rad | m], which must have the unit of ``quantity``."""
    if text is None:
        return None
    try:
        return read_number(text, quantity)[0]
    except ConfigError as error:
        raise ConfigError(f"--position: {error}") from None
