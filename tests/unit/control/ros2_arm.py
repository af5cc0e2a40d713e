"""A JointTrajectoryController of ROS 2 over the toy robot."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from toy_robot import ToyRobot

from tool0.control.ros2.joint_trajectory import JointTrajectoryController
from tool0.control.trajectory import TrajectoryGoal
from tool0.description.model import Interface
from tool0.protocol.trajectories import TrajectoryPoint

JTC = "joint_trajectory_controller/JointTrajectoryController"
NAMES = ("hip", "slide", "wheel")
REST = [0.0, 0.0, 0.0]
GAINS = {
    Interface.POSITION: {},
    Interface.EFFORT: {"p": 4000, "d": 126, "i": 10, "i_clamp": 1},
    Interface.VELOCITY: {"p": 20, "ff_velocity_scale": 1},
}

Point = TrajectoryPoint


def goal(*points: Point, **options: Any) -> TrajectoryGoal:
    return TrajectoryGoal(points=list(points), **options)


def yaml(interface: Interface, changes: Mapping[str, object]) -> str:
    """Return the YAML of ``arm``, in which ``changes`` by dotted name replace.

    Its tolerances are 0.1 on the path and 0.01 at the goal, its goal time is 0.5 s.
    """
    parameters: dict[str, object] = {
        "type": JTC,
        "joints": f"[{', '.join(NAMES)}]",
        "command_interfaces": f"[{interface.name.lower()}]",
        "state_interfaces": "[position, velocity]",
        "constraints.goal_time": 0.5,
        "constraints.stopped_velocity_tolerance": 0.05,
    }
    for name in NAMES:
        parameters[f"constraints.{name}.trajectory"] = 0.1
        parameters[f"constraints.{name}.goal"] = 0.01
        for gain, value in GAINS[interface].items():
            parameters[f"gains.{name}.{gain}"] = value
    parameters.update(changes)
    lines = [f"    {name}: {value}" for name, value in parameters.items()]
    return "\n".join(["arm:", "  ros__parameters:", *lines])


def arm(
    changes: Mapping[str, object] | None = None,
    interface: Interface = Interface.POSITION,
) -> tuple[ToyRobot, JointTrajectoryController]:
    """Return a robot with a running controller."""
    robot = ToyRobot(yaml(interface, changes or {}), interface)
    controller = robot.start("arm")
    assert isinstance(controller, JointTrajectoryController)
    return robot, controller
