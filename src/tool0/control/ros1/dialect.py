"""The controllers and the YAML of ros_control."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from tool0.control.dialect import ControllerType, Declared, Dialect, Stages
from tool0.description.yaml_tree import YamlEntry
from tool0.description.yaml_values import Namespace
from tool0.protocol.controllers import Role

_FORWARD = ControllerType(Role.COMMAND, "tool0.control.ros1.forward_command")
_GRIPPER = ControllerType(Role.GRIPPER, "tool0.control.ros1.gripper_action")
_TRAJECTORY = ControllerType(Role.TRAJECTORY, "tool0.control.ros1.joint_trajectory")

_SAMPLE = """
joint: "*"
joints: ["*"]
publish_rate: 1
gains: {"*": {p: 1}}
pid: {p: 1}
"*": {pid: {p: 1}}
"""


def _declared(root: YamlEntry) -> Mapping[str, Declared]:
    """Return the controllers, which are the namespaces that have a ``type``."""
    return {
        name: Declared(entry.children["type"], entry)
        for name, entry in root.children.items()
        if "type" in entry.children
    }


def _joint_limits(root: YamlEntry) -> Namespace | None:
    return Namespace(root).namespace("joint_limits")


ROS1: Final = Dialect(
    name="ros1",
    title="ROS 1",
    types={
        "joint_state_controller/JointStateController": ControllerType(
            Role.READER, "tool0.control.ros1.joint_state"
        ),
        "effort_controllers/JointTrajectoryController": _TRAJECTORY,
        "position_controllers/JointTrajectoryController": _TRAJECTORY,
        "velocity_controllers/JointTrajectoryController": _TRAJECTORY,
        "effort_controllers/GripperActionController": _GRIPPER,
        "position_controllers/GripperActionController": _GRIPPER,
        "effort_controllers/JointEffortController": _FORWARD,
        "effort_controllers/JointPositionController": _FORWARD,
        "effort_controllers/JointVelocityController": _FORWARD,
        "effort_controllers/JointGroupEffortController": _FORWARD,
        "effort_controllers/JointGroupPositionController": _FORWARD,
        "position_controllers/JointPositionController": _FORWARD,
        "position_controllers/JointGroupPositionController": _FORWARD,
        "velocity_controllers/JointPositionController": _FORWARD,
        "velocity_controllers/JointVelocityController": _FORWARD,
        "velocity_controllers/JointGroupVelocityController": _FORWARD,
    },
    declared=_declared,
    parameters=lambda root, name: root.children.get(name),
    joint_limits=_joint_limits,
    control_period=lambda root: None,
    stages=Stages("unconfigured", "initialized", "running", "stopped"),
    common=frozenset({"type"}),
    sample=_SAMPLE,
    linter="tool0.control.ros1.lint",
    is_configured_when_loaded=True,
    restarts_by_switch=False,
    needs_known_controller=False,
    bases=dict.fromkeys(Role, "controller_interface::ControllerBase"),
)
