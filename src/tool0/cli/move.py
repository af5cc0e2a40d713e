"""``tool0 move``: joints or the tool of a running bringup to a place."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from tool0.cli.connection import Bringup, see_through
from tool0.cli.parsing import joint_values, parse
from tool0.description.model import Pose
from tool0.errors import ConfigError, ControlError, nearest_name

if TYPE_CHECKING:
    from tool0.interfaces.socket.client import RemoteRobot, RemoteStatus

SixNumbers = tuple[float, float, float, float, float, float]

_TYPE = "/JointTrajectoryController"
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
        "arm": arm,
    }
    if (pose is None) == (not joints):
        raise ConfigError("give either --joints, joint=position …, or --pose")
    if pose is None:
        _refuse("--pose", {**of_pose, "linear": linear or None})
        duration = 2.0 if duration is None else duration
        return _move_joints(joints, duration, controller, timeout, bringup)
    _refuse("--joints", {"duration": duration, "controller": controller})
    given = {name: value for name, value in of_pose.items() if value is not None}
    x, y, z, roll, pitch, yaw = pose
    target = Pose(xyz=(x, y, z), rpy=(roll, pitch, yaw))
    with bringup.connect() as robot:
        way = robot.arm.move_linear if linear else robot.arm.move_to
        return see_through(robot, partial(way, target, **given), timeout)


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
    from tool0.control.trajectory import TrajectoryPoint

    wanted = joint_values(joints, "--joints")
    if not 0.0 < duration < math.inf:
        raise ConfigError(f"--duration must be above 0 s, got {duration}")
    with bringup.connect() as robot:
        chosen = find_controller(robot.controllers(), wanted, controller)
        names, positions = _target(robot, chosen, wanted)
        zeros = [0.0] * len(names)
        # Velocities given make the motion a cubic: it starts and ends softly.
        point = TrajectoryPoint(positions, zeros, time_from_start=duration)
        handle = robot.controller(chosen.name)
        follow = partial(handle.follow, [point], joint_names=names)
        return see_through(robot, follow, timeout)


def find_controller(
    controllers: Sequence[RemoteStatus],
    wanted: Mapping[str, float],
    name: str | None = None,
) -> RemoteStatus:
    """Return the running trajectory controller of all wanted joints."""
    running = [
        item
        for item in controllers
        if item.state == "running" and item.type.endswith(_TYPE)
    ]
    if name is not None:
        running = [item for item in running if item.name == name]
        if not running:
            raise ControlError(
                f"no trajectory controller '{name}' is running; "
                "see `tool0 controllers list`"
            )
    fitting = [item for item in running if wanted.keys() <= _joints(item)]
    if fitting:
        return fitting[0]
    claimed = {joint for item in running for joint in _joints(item)}
    for joint in wanted:
        if joint not in claimed:
            raise ControlError(
                f"no running trajectory controller claims joint '{joint}'"
                f"{nearest_name(joint, claimed)}"
            )
    raise ControlError(
        f"no single controller claims {', '.join(wanted)}; move them one after another"
    )


def _joints(status: RemoteStatus) -> set[str]:
    return {joint for _, joints in status.claimed for joint in joints}


def _target(
    robot: RemoteRobot, status: RemoteStatus, wanted: Mapping[str, float]
) -> tuple[list[str], list[float]]:
    """Return all joints of the controller, and where they should go.

    The others keep the place that is desired, not measured: the arm droops a little
    below it, and would creep down with every move.
    """
    names = [joint for _, joints in status.claimed for joint in joints]
    desired = robot.controller(status.name).query_state()
    held = dict(zip(names, desired.positions, strict=True))
    return names, [wanted.get(name, held[name]) for name in names]
