"""The parts that the MoveIt packages of both versions of ROS have in common."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any, Final, final

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
from tool0.installation.templates import filled

MOVEIT_SUFFIX: Final = "_moveit_config"
"""Suffix of the package's name."""
_PLANNERS: Final = ("RRTConnect", "RRT", "RRTstar", "PRM", "LBKPIECE", "BiTRRT")
"""Planners of OMPL.  The first planner is the default."""
_SOLVER: Final = "kdl_kinematics_plugin/KDLKinematicsPlugin"

Controllers = Mapping[str, Mapping[str, Any]]
"""Parameters of each controller, by controller name, as in ros_control's YAML."""


@final
class RobotPackage:
    """Name, groups and common files of the package ``NAME_moveit_config``."""

    def __init__(self, description: RobotDescription) -> None:
        """Find the planning groups of the robot.

        Raises:
            DescriptionError: If the robot is not from the catalogue.
        """
        self._description = description
        self.groups: Final = planning_groups(description)
        self.name: Final = package_stem(description)
        self.path: Final = PurePosixPath(self.name + MOVEIT_SUFFIX)
        """Path of the package's folder, relative to ``src``."""
        self._arms = arm_groups(self.groups)

    def config(
        self,
        urdf: str,
        disabled: Mapping[tuple[str, str], str],
        limits: Mapping[str, Mapping[str, float]],
    ) -> dict[str, str]:
        """Return the ``config`` files that both versions of ROS have, by name.

        Args:
            urdf: The description of the robot.
            disabled: Reasons for the pairs of links that are not checked for
                collisions, by pair.
            limits: The joint limits in the controllers' YAML.
        """
        return {
            f"{self.name}.urdf": urdf,
            f"{self.name}.srdf": to_srdf(self._description, disabled),
            "joint_limits.yaml": joint_limits(self._description.model, limits),
            "kinematics.yaml": kinematics(self._arms),
        }

    def files(
        self, template: Path, config: Mapping[str, str], words: Mapping[str, str]
    ) -> dict[PurePosixPath, str]:
        """Return the files of the package, by path.

        Args:
            template: Folder of the package's launch files and manifest.
            config: Files of the package's folder ``config``, by name.
            words: Replacements for the template words other than ``@robot@`` and
                ``@group@``, by word.
        """
        group = ALL_ARMS if len(self._arms) > 1 else self._arms[0].name
        files = {self.path / "config" / file: text for file, text in config.items()}
        known = {"@robot@": self.name, "@group@": group}
        return files | filled(template, self.path, {**known, **words})


def package_stem(description: RobotDescription) -> str:
    """Return the name of a robot or cell, with only characters that catkin allows."""
    cell, (first, *_) = description.cell, description.robots
    if cell is None:
        words = [part.name for part in first.parts]
    else:
        words = [cell.name] if cell.name else [r.name for r in description.robots]
    name = re.sub(r"[^a-z0-9]+", "_", "_".join(words).lower()).strip("_")
    return name if name[:1].isalpha() else f"robot_{name}"


def joint_limits(model: RobotModel, own: Mapping[str, Mapping[str, float]]) -> str:
    """Return the joint limits as YAML.

    ``own`` contains the limits in the controllers' YAML.
    """
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
    return commented_yaml(about, {**scaling, "joint_limits": limits})


def kinematics(arms: list[ArmGroup]) -> str:
    """Return the solvers of inverse kinematics as YAML."""
    solver = {
        "kinematics_solver": _SOLVER,
        "kinematics_solver_search_resolution": 0.005,
        "kinematics_solver_timeout": 0.05,
    }
    about = "Solvers of inverse kinematics; KDL's is part of moveit_kinematics."
    return commented_yaml(about, {arm.name: dict(solver) for arm in arms})


def planners(groups: Sequence[Group], pipeline: Mapping[str, object]) -> str:
    """Return the planners of OMPL as YAML, preceded by the ``pipeline`` parameters."""
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
    whole = {**pipeline, "planner_configs": planners, **planning}
    return commented_yaml(about, whole)


def controllers_with_action(
    controllers: Controllers, actions: Mapping[str, tuple[str, str]]
) -> dict[str, dict[str, object]]:
    """Return the controllers that have an action for MoveIt, with their joints.

    Args:
        controllers: Parameters of the controllers, including their types.
        actions: Name of the action, and MoveIt's name for the action's type, by suffix
            of the controller type.

    Raises:
        ConfigError: If no controller has an action for MoveIt.
    """
    found: dict[str, dict[str, object]] = {}
    for name, parameters in controllers.items():
        action = actions.get(str(parameters.get("type")).rpartition("/")[2])
        if action is not None:
            joints = parameters.get("joints") or [parameters["joint"]]
            found[name] = {
                "action_ns": action[0],
                "type": action[1],
                "default": True,
                "joints": list(joints),
            }
    if not found:
        raise ConfigError(
            "the robot has no controllers with an action that MoveIt uses"
        )
    return found


def commented_yaml(about: str, content: Mapping[str, object]) -> str:
    """Return a YAML document with a comment above it."""
    import yaml

    comment = "".join(f"# {line}\n" for line in about.splitlines())
    return comment + yaml.safe_dump(content, sort_keys=False, allow_unicode=True)
