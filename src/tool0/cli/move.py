"""``tool0 move``: joints of a running bringup along a trajectory."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from tool0.cli.connection import Bringup, see_through
from tool0.cli.options import joint_values
from tool0.cli.parsing import parse
from tool0.errors import ConfigError, ControlError, nearest_name

if TYPE_CHECKING:
    from tool0.remote.client import RemoteRobot, RemoteStatus

_TYPE = "/JointTrajectoryController"
_DEFAULT = Bringup()


def run(command: str, arguments: list[str]) -> int:
    """Run the command and return its exit status."""
    return parse(move, command, arguments)


def move(
    *,
    joints: tuple[str, ...],
    duration: float = 2.0,
    controller: str | None = None,
    timeout: float | None = None,
    bringup: Bringup = _DEFAULT,
) -> int:
    """Move joints, and wait until they are there; Ctrl-C stops the robot.

    Args:
        joints: joint=position … [rad]; joints not given keep their place.
        duration: How long the motion takes [simulated s].
        controller: A trajectory controller; found by the joints if left out.
        timeout: Stop the motion after so many wall seconds.
        bringup: Which bringup.
    """
    from tool0.control.trajectory import TrajectoryPoint

    wanted = joint_values(joints, "--joints")
    if not wanted:
        raise ConfigError("--joints: write joint=position …, in radians")
    if not 0.0 < duration < math.inf:
        raise ConfigError(f"--duration must be above 0 s, got {duration}")
    with bringup.connect() as robot:
        chosen = find_controller(robot.controllers(), wanted, controller)
        names, positions = _target(robot, chosen, wanted)
        zeros = [0.0] * len(names)
        # Velocities given make the motion a cubic: it starts and ends softly.
        point = TrajectoryPoint(positions, zeros, time_from_start=duration)
        handle = robot.controller(chosen.name)
        return see_through(lambda: handle.follow([point], joint_names=names), timeout)


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
