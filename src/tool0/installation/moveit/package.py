"""Writes the files of a MoveIt 1 configuration package.

The layout is the same as that of MoveIt's setup assistant.  The launch files and the
manifest are the same for every robot (``template``).  The files in ``config`` are
generated from the robot's description.
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

_WITH_GAZEBO: Final = "demo_gazebo.launch"
"""Name of the launch file that uses tool0_gazebo, which supports only one robot."""
_DEPENDS_ON_GAZEBO: Final = "  <exec_depend>tool0_gazebo</exec_depend>\n"
_TEMPLATE: Final = Path(__file__).parent / "template"
_ACTIONS: Final = {
    "JointTrajectoryController": ("follow_joint_trajectory", "FollowJointTrajectory"),
    "GripperActionController": ("gripper_cmd", "GripperCommand"),
}
"""Name of the action, and MoveIt's name for the action's type, by controller type."""


def moveit_package(
    description: RobotDescription,
    *,
    disabled: Mapping[tuple[str, str], str],
    controllers: Controllers,
    action_controllers: Controllers,
) -> dict[PurePosixPath, bytes]:
    """Return the files of ``NAME_moveit_config``, by path relative to ``src``.

    NAME is the name of the cell.  Without a cell, NAME consists of the names of the
    robots, or of the names of the arm and gripper.

    Args:
        description: One robot or several robots from the catalogue.
        disabled: Reasons for the pairs of links that are not checked for collisions, by
            pair.
        controllers: The ros_control YAML of the robot.
        action_controllers: The ros_control YAML, but with grippers that are driven by
            an action.

    Raises:
        DescriptionError: If the robot is not from the catalogue.
    """
    package = RobotPackage(description)
    config = {
        **package.config(
            description.urdf, disabled, controllers.get("joint_limits", {})
        ),
        "ompl_planning.yaml": planners(package.groups, {}),
        "simple_moveit_controllers.yaml": _simple(controllers),
        "simple_moveit_gripper_action_controllers.yaml": _simple(action_controllers),
        "fake_controllers.yaml": commented_yaml(
            "Controllers that only pretend, and where the joints are at the start.",
            {
                "controller_list": [
                    {
                        "name": f"fake_{group.name}_controller",
                        "type": "$(arg fake_execution_type)",
                        "joints": list(group.joints),
                    }
                    for group in package.groups
                ],
                "initial": [
                    {"group": group.name, "pose": "home"}
                    for group in package.groups
                    if "home" in group.states
                ],
            },
        ),
    }
    files = package.files(_TEMPLATE, config, {})
    if description.cell is not None:
        del files[package.path / "launch" / _WITH_GAZEBO]
        manifest = package.path / "package.xml"
        files[manifest] = files[manifest].replace(_DEPENDS_ON_GAZEBO, "")
    return {path: text.encode() for path, text in files.items()}


def _simple(controllers: Controllers) -> str:
    found = controllers_with_action(controllers, _ACTIONS)
    return commented_yaml(
        "Controllers whose actions execute plans; they are loaded elsewhere.",
        {"controller_list": [{"name": name, **item} for name, item in found.items()]},
    )
