"""The files of a MoveIt 1 configuration package.

The layout is that of MoveIt's setup assistant.  Launch files and manifest are the same
for every robot (``template``); the files in ``config`` are written from its description.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any, Final

from tool0.description.robot import RobotDescription
from tool0.errors import ConfigError
from tool0.installation.moveit.semantics import (
    ALL_ARMS,
    ArmGroup,
    arm_groups,
    planning_groups,
    to_srdf,
)

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
    name: str,
    description: RobotDescription,
    *,
    disabled: Mapping[tuple[str, str], str],
    controllers: Controllers,
    action_controllers: Controllers,
    ramp: float,
) -> dict[PurePosixPath, bytes]:
    """Return the files of the package ``NAME_moveit_config`` by path, below ``src``.

    Args:
        name: The robot's name; it names the SRDF and the URDF.
        description: One robot of the catalogue, or several.
        disabled: Pairs of links not to check for collisions → reason.
        controllers: The ros_control YAML of the robot.
        action_controllers: The same with grippers driven by an action.
        ramp: Time in which every joint can reach its largest velocity [s]: it defines
            the limits of acceleration.

    Raises:
        DescriptionError: If the robot is not of the catalogue.
    """
    groups = planning_groups(description)
    arms = arm_groups(groups)
    config = {
        f"{name}.urdf": description.urdf,
        f"{name}.srdf": to_srdf(description, disabled),
        "joint_limits.yaml": _joint_limits(description, ramp),
        "kinematics.yaml": _kinematics(arms),
        "ompl_planning.yaml": _ompl([*(group.name for group in groups)], arms),
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
    package = PurePosixPath(f"{name}_moveit_config")
    words = {"@robot@": name, "@group@": ALL_ARMS if len(arms) > 1 else arms[0].name}
    files = {package / "config" / file: text for file, text in config.items()}
    for path in sorted(_TEMPLATE.rglob("*")):
        if path.is_file():
            text = path.read_text(encoding="utf-8")
            for word, meaning in words.items():
                text = text.replace(word, meaning)
            files[package / path.relative_to(_TEMPLATE).as_posix()] = text
    return {path: text.encode() for path, text in files.items()}


def _joint_limits(description: RobotDescription, ramp: float) -> str:
    model = description.model
    limits = {
        name: {
            "has_velocity_limits": True,
            "max_velocity": model.joint(name).max_velocity,
            "has_acceleration_limits": True,
            "max_acceleration": round(model.joint(name).max_velocity / ramp, 6),
        }
        for name in model.transmission_by_joint
    }
    about = (
        "Limits of the joints [rad/s, rad/s² | m/s, m/s²]; positions are in the URDF.\n"
        "Velocities are those of the URDF.  There are no published accelerations: these\n"
        f"reach the largest velocity in {ramp} s, the rule of tool0's own planner."
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


def _ompl(names: list[str], arms: list[ArmGroup]) -> str:
    if len(arms) > 1:
        names.append(ALL_ARMS)
    first_joints = {arm.name: arm.joints[:2] for arm in arms}
    groups: dict[str, object] = {
        name: {
            "default_planner_config": _PLANNERS[0],
            "planner_configs": list(_PLANNERS),
            "longest_valid_segment_fraction": 0.005,
            **(
                {"projection_evaluator": f"joints({','.join(first_joints[name])})"}
                if name in first_joints
                else {}
            ),
        }
        for name in names
    }
    planners = {name: {"type": f"geometric::{name}"} for name in _PLANNERS}
    about = "Planners of OMPL, with their default parameters, and those of each group."
    return _yaml(about, {"planner_configs": planners, **groups})


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
