"""Writes the files of a MoveIt 2 configuration package.

The layout is the same as that of MoveIt's setup assistant, so that MoveItConfigsBuilder
can read it.  The launch files and the manifest are the same for every robot
(``template_ros2``).  The files in ``config`` are generated from the robot's
description.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Final

from tool0.description.robot import RobotDescription
from tool0.installation.moveit.configuration import (
    Controllers,
    RobotPackage,
    commented_yaml,
    controllers_with_action,
    planners,
)

_TEMPLATE: Final = Path(__file__).parent / "template_ros2"
_SIMULATED: Final = "gz_ros2_control/GazeboSimSystem"
_MOCK: Final = "mock_components/GenericSystem"
"""The ros2_control plugin of the demo that runs without a simulator."""
_ACTIONS: Final = {
    "JointTrajectoryController": ("follow_joint_trajectory", "FollowJointTrajectory"),
    "GripperActionController": ("gripper_cmd", "ParallelGripperCommand"),
}
_PIPELINE: Final = {
    "planning_plugins": ["ompl_interface/OMPLPlanner"],
    "request_adapters": [
        "default_planning_request_adapters/ResolveConstraintFrames",
        "default_planning_request_adapters/ValidateWorkspaceBounds",
        "default_planning_request_adapters/CheckStartStateBounds",
        "default_planning_request_adapters/CheckStartStateCollision",
    ],
    "response_adapters": [
        "default_planning_response_adapters/AddTimeOptimalParameterization",
        "default_planning_response_adapters/ValidateSolution",
        "default_planning_response_adapters/DisplayMotionPath",
    ],
}
"""Parameters of the OMPL pipeline for Jazzy and later distributions."""
_CARTESIAN_LIMITS: Final = {
    "max_trans_vel": 1.0,
    "max_trans_acc": 2.25,
    "max_trans_dec": -5.0,
    "max_rot_vel": 1.57,
}
"""Cartesian limits from MoveIt's setup assistant [m/s, m/s², rad/s]."""


def moveit2_package(
    description: RobotDescription,
    *,
    disabled: Mapping[tuple[str, str], str],
    controllers: Controllers,
    limits: Mapping[str, Mapping[str, float]],
) -> dict[PurePosixPath, bytes]:
    """Return the files of ``NAME_moveit_config``, by path relative to ``src``.

    Args:
        description: One robot or several robots from the catalogue, with
            ``<ros2_control>``.
        disabled: Reasons for the pairs of links that are not checked for collisions, by
            pair.
        controllers: Parameters of the robot's controllers for ROS 2, including their
            types.
        limits: The joint limits in the controllers' YAML.

    Raises:
        DescriptionError: If the robot is not from the catalogue.
        ConfigError: If no controller has an action for MoveIt.
    """
    package = RobotPackage(description)
    actions = controllers_with_action(controllers, _ACTIONS)
    config = {
        **package.config(description.urdf.replace(_SIMULATED, _MOCK), disabled, limits),
        "ompl_planning.yaml": planners(package.groups, _PIPELINE),
        "pilz_cartesian_limits.yaml": commented_yaml(
            "Limits of the tool for the pipeline of Pilz [m/s, m/s², rad/s].",
            {"cartesian_limits": _CARTESIAN_LIMITS},
        ),
        "moveit_controllers.yaml": commented_yaml(
            "Controllers whose actions execute plans; they are loaded elsewhere.",
            {
                "moveit_controller_manager": (
                    "moveit_simple_controller_manager/MoveItSimpleControllerManager"
                ),
                "trajectory_execution": {
                    "allowed_execution_duration_scaling": 1.2,
                    "allowed_goal_duration_margin": 1.0,
                    "allowed_start_tolerance": 0.01,
                },
                "moveit_simple_controller_manager": {
                    "controller_names": list(actions),
                    **actions,
                },
            },
        ),
    }
    words = {
        "@controllers@": f"{package.name}_controllers",
        "@started@": ", ".join(f'"{n}"' for n in ["joint_state_broadcaster", *actions]),
    }
    files = package.files(_TEMPLATE, config, words)
    return {path: text.encode() for path, text in files.items()}
