"""The files of a MoveIt 1 configuration package.

The layout is that of MoveIt's setup assistant.  Launch files and manifest are the same
for every robot (``template``); those in ``config`` are written from its description.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any, Final

from tool0.description.model import TIME_TO_FULL_SPEED, RobotModel
from tool0.description.robot import RobotDescription
from tool0.errors import ConfigError
from tool0.installation.moveit.semantics import (
    ALL_ARMS,
    ArmGroup,
    Group,
    arm_groups,
    planning_groups,
    to_srdf,
)

MOVEIT_SUFFIX: Final = "_moveit_config"
"""The end of the package's name."""
_WITH_GAZEBO: Final = "demo_gazebo.launch"
"""The launch file with tool0_gazebo, which is for one robot."""
_DEPENDS_ON_GAZEBO: Final = "  <exec_depend>tool0_gazebo</exec_depend>\n"
_TEMPLATE: Final = Path(__file__).parent / "template"
_PLANNERS: Final = ("RRTConnect", "RRT", "RRTstar", "PRM", "LBKPIECE", "BiTRRT")
"""Planners of OMPL; the first is the default."""
_SOLVER: Final = "kdl_kinematics_plugin/KDLKinematicsPlugin"
_ACTIONS: Final = {
    "JointTrajectoryController": ("follow_joint_trajectory", "FollowJointTrajectory"),
    "GripperActionController": ("gripper_cmd", "GripperCommand"),
}
"""Type of a controller → its action, and MoveIt's name for the action's type."""

Controllers = Mapping[str, Mapping[str, Any]]
"""Controller → its parameters, as in ros_control YAML."""


def moveit_package(
    description: RobotDescription,
    *,
    disabled: Mapping[tuple[str, str], str],
    controllers: Controllers,
    action_controllers: Controllers,
) -> dict[PurePosixPath, bytes]:
    """Return the files of the package ``NAME_moveit_config`` by path, below ``src``.

    NAME is that of the cell, or else consists of the names of robots, or of arm and
    gripper.

    Args:
        description: One robot of the catalogue, or several.
        disabled: Pairs of links not to check for collisions → reason.
        controllers: The ros_control YAML of the robot.
        action_controllers: The same with grippers driven by an action.

    Raises:
        DescriptionError: If the robot is not of the catalogue.
    """
    groups = planning_groups(description)
    arms = arm_groups(groups)
    name = _name(description)
    config = {
        f"{name}.urdf": description.urdf,
        f"{name}.srdf": to_srdf(description, disabled),
        "joint_limits.yaml": _joint_limits(description.model, controllers),
        "kinematics.yaml": _kinematics(arms),
        "ompl_planning.yaml": _ompl(groups),
        "simple_moveit_controllers.yaml": _simple_controllers(controllers),
        "simple_moveit_gripper_action_controllers.yaml": _simple_controllers(
            action_controllers
        ),
        "fake_controllers.yaml": _yaml(
            "Controllers that only pretend, and where the joints are at the start.",
            {
                "controller_list": [
                    {
                        "name": f"fake_{group.name}_controller",
                        "type": "$(arg fake_execution_type)",
                        "joints": list(group.joints),
                    }
                    for group in groups
                ],
                "initial": [
                    {"group": group.name, "pose": "home"}
                    for group in groups
                    if "home" in group.states
                ],
            },
        ),
    }
    package = PurePosixPath(name + MOVEIT_SUFFIX)
    words = {"@robot@": name, "@group@": ALL_ARMS if len(arms) > 1 else arms[0].name}
    files = {package / "config" / file: text for file, text in config.items()}
    for path in sorted(_TEMPLATE.rglob("*")):
        if path.is_file() and (description.cell is None or path.name != _WITH_GAZEBO):
            text = path.read_text(encoding="utf-8")
            for word, meaning in words.items():
                text = text.replace(word, meaning)
            if description.cell is not None:
                text = text.replace(_DEPENDS_ON_GAZEBO, "")
            files[package / path.relative_to(_TEMPLATE).as_posix()] = text
    return {path: text.encode() for path, text in files.items()}


def _name(description: RobotDescription) -> str:
    """Return the name of a robot or cell, in the letters that catkin allows."""
    cell, (first, *_) = description.cell, description.robots
    if cell is None:
        words = [part.name for part in first.parts]
    else:
        words = [cell.name] if cell.name else [r.name for r in description.robots]
    name = re.sub(r"[^a-z0-9]+", "_", "_".join(words).lower()).strip("_")
    return name if name[:1].isalpha() else f"robot_{name}"


def _joint_limits(model: RobotModel, controllers: Controllers) -> str:
    own = controllers.get("joint_limits", {})
    limits = {}
    for name in model.transmission_by_joint:
        joint = model.joint(name)
        acceleration = own.get(name, {}).get("max_acceleration", math.inf)
        limits[name] = {
            "has_velocity_limits": True,
            "max_velocity": joint.max_velocity,
            "has_acceleration_limits": True,
            "max_acceleration": round(min(joint.max_acceleration, acceleration), 6),
        }
    about = (
        "Limits of the joints [rad/s, rad/s² | m/s, m/s²]; positions are in the URDF.\n"
        "Velocities are those of the URDF.  No accelerations are published: these are\n"
        "those of tool0's own motions.  They reach full speed in\n"
        f"{TIME_TO_FULL_SPEED} s, or less fast where the drive is too weak, as\n"
        "`tool0 describe controllers` derives."
    )
    scaling = {
        "default_velocity_scaling_factor": 0.1,
        "default_acceleration_scaling_factor": 0.1,
    }
    return _yaml(about, {**scaling, "joint_limits": limits})


def _kinematics(arms: list[ArmGroup]) -> str:
    solver = {
        "kinematics_solver": _SOLVER,
        "kinematics_solver_search_resolution": 0.005,
        "kinematics_solver_timeout": 0.05,
    }
    about = "Solvers of inverse kinematics; KDL's is part of moveit_kinematics."
    return _yaml(about, {arm.name: dict(solver) for arm in arms})


def _ompl(groups: Sequence[Group]) -> str:
    arms = arm_groups(groups)
    joints_of = {group.name: group.joints for group in groups}
    if len(arms) > 1:
        joints_of[ALL_ARMS] = arms[0].joints
    planning: dict[str, object] = {
        name: {
            "default_planner_config": _PLANNERS[0],
            "planner_configs": list(_PLANNERS),
            "longest_valid_segment_fraction": 0.005,
            "projection_evaluator": f"joints({','.join(joints[:2])})",
        }
        for name, joints in joints_of.items()
    }
    planners = {name: {"type": f"geometric::{name}"} for name in _PLANNERS}
    about = "Planners of OMPL, with their default parameters, and those of each group."
    return _yaml(about, {"planner_configs": planners, **planning})


def _simple_controllers(controllers: Controllers) -> str:
    """Return the controllers that have an action for MoveIt, and their joints."""
    found = []
    for name, parameters in controllers.items():
        action = _ACTIONS.get(str(parameters.get("type")).rpartition("/")[2])
        if action is not None:
            joints = parameters.get("joints") or [parameters["joint"]]
            found.append(
                {
                    "name": name,
                    "action_ns": action[0],
                    "type": action[1],
                    "default": True,
                    "joints": list(joints),
                }
            )
    if not found:
        raise ConfigError(
            "the robot has no controllers with an action that MoveIt uses"
        )
    return _yaml(
        "Controllers whose actions execute plans; they are loaded elsewhere.",
        {"controller_list": found},
    )


def _yaml(about: str, content: Mapping[str, object]) -> str:
    """Return a YAML document with a comment above it."""
    import yaml

    comment = "".join(f"# {line}\n" for line in about.splitlines())
    return comment + yaml.safe_dump(content, sort_keys=False, allow_unicode=True)
