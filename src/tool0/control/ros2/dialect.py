"""The controllers and the YAML of ros2_control."""

from __future__ import annotations

from typing import Final

from tool0.control.dialect import ControllerType, Dialect, Stages
from tool0.control.ros2.layout import (
    control_period,
    declared,
    joint_limits,
    parameters,
)
from tool0.protocol.controllers import Role

_TRAJECTORY = ControllerType(
    Role.TRAJECTORY, "tool0.control.ros2.trajectory_parameters"
)
_PASSTHROUGH = ControllerType(
    Role.TRAJECTORY, "tool0.control.ros2.passthrough_trajectory"
)
_ARM_MODE = ControllerType(Role.MOTION, "tool0.control.ros2.arm_modes")
_FORWARD = ControllerType(Role.COMMAND, "tool0.control.ros2.forward_command")
_GRIPPER = ControllerType(Role.GRIPPER, "tool0.control.ros2.gripper_action")
_BROADCASTER = ControllerType(Role.READER, "tool0.control.ros2.broadcasters")
_DEVICE = ControllerType(Role.READER, "tool0.control.ros2.device_io")

_COMMON = frozenset(
    {
        *("type", "params_file", "fallback_controllers", "node_options_args"),
        *("update_rate", "is_async", "async_parameters", "thread_priority"),
        *("use_sim_time", "qos_overrides", "start_type_description_service"),
    }
)

_SAMPLE = """
joint: "*"
joints: ["*"]
interface_name: position
interface_names: [position]
command_interfaces: [position]
state_interfaces: [position, velocity]
gains: {"*": {p: 1.0}}
sensor_name: sensor
state_interface_names: [force.x]
topic_name: topic
frame_id: frame
pose_name: pose
"""

ROS2: Final = Dialect(
    name="ros2",
    title="ROS 2",
    types={
        "joint_state_broadcaster/JointStateBroadcaster": ControllerType(
            Role.READER, "tool0.control.ros2.joint_state_broadcaster"
        ),
        "joint_trajectory_controller/JointTrajectoryController": _TRAJECTORY,
        "ur_controllers/ScaledJointTrajectoryController": _TRAJECTORY,
        "ur_controllers/PassthroughTrajectoryController": _PASSTHROUGH,
        "ur_controllers/FreedriveModeController": _ARM_MODE,
        "ur_controllers/ForceModeController": _ARM_MODE,
        "forward_command_controller/ForwardCommandController": _FORWARD,
        "forward_command_controller/MultiInterfaceForwardCommandController": _FORWARD,
        "position_controllers/JointGroupPositionController": _FORWARD,
        "velocity_controllers/JointGroupVelocityController": _FORWARD,
        "effort_controllers/JointGroupEffortController": _FORWARD,
        "position_controllers/GripperActionController": _GRIPPER,
        "effort_controllers/GripperActionController": _GRIPPER,
        "parallel_gripper_action_controller/GripperActionController": _GRIPPER,
        "force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster": _BROADCASTER,
        "pose_broadcaster/PoseBroadcaster": _BROADCASTER,
        "ur_controllers/ForceTorqueStateBroadcaster": _BROADCASTER,
        "ur_controllers/SpeedScalingStateBroadcaster": _BROADCASTER,
        "ur_controllers/GPIOController": _DEVICE,
        "robotiq_controllers/RobotiqActivationController": _DEVICE,
    },
    declared=declared,
    parameters=parameters,
    joint_limits=joint_limits,
    control_period=control_period,
    stages=Stages("unconfigured", "inactive", "active", "inactive"),
    common=_COMMON,
    sample=_SAMPLE,
    linter="tool0.control.ros2.lint",
    is_configured_when_loaded=False,
    restarts_by_switch=True,
    needs_known_controller=True,
    bases=dict.fromkeys(Role, "controller_interface::ControllerInterface"),
)
