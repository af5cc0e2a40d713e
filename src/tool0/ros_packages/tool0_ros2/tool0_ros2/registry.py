"""Classes of the parts that present controllers and other items in ROS.

Each entry has the form ``module:Class`` and refers to a module in this package.  The
module is imported when it is needed.
"""

from importlib import import_module
from typing import Any

_TRAJECTORY = "trajectory:JointTrajectoryPart"
_PASSTHROUGH = "trajectory:FollowTrajectoryPart"
_FORWARD = "forward:ForwardCommandPart"

CONTROLLERS = {
    "joint_state_broadcaster/JointStateBroadcaster": "joint_states:JointStatePart",
    "joint_trajectory_controller/JointTrajectoryController": _TRAJECTORY,
    "ur_controllers/ScaledJointTrajectoryController": _TRAJECTORY,
    "ur_controllers/PassthroughTrajectoryController": _PASSTHROUGH,
    "ur_controllers/FreedriveModeController": "freedrive:FreedrivePart",
    "ur_controllers/ForceModeController": "force_mode:ForceModePart",
    "forward_command_controller/ForwardCommandController": _FORWARD,
    "forward_command_controller/MultiInterfaceForwardCommandController": _FORWARD,
    "position_controllers/JointGroupPositionController": _FORWARD,
    "velocity_controllers/JointGroupVelocityController": _FORWARD,
    "effort_controllers/JointGroupEffortController": _FORWARD,
    "position_controllers/GripperActionController": "gripper:GripperCommandPart",
    "effort_controllers/GripperActionController": "gripper:GripperCommandPart",
    "parallel_gripper_action_controller/GripperActionController": (
        "gripper:ParallelGripperPart"
    ),
    "robotiq_controllers/RobotiqActivationController": "activation:ActivationPart",
    "ur_controllers/GPIOController": "gpio:GpioPart",
    "ur_controllers/SpeedScalingStateBroadcaster": "speed_scaling:SpeedScalingPart",
    "ur_controllers/ForceTorqueStateBroadcaster": "wrench:WrenchPart",
    "force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster": (
        "wrench:WrenchPart"
    ),
    "pose_broadcaster/PoseBroadcaster": "pose:PosePart",
}
"""Part of each controller type.  The part is created with a ControllerContext."""

ROBOT = ["dashboard:DashboardPart", "cameras:CamerasPart"]
"""Parts of each namespace that have no controller.  The parts are created with a
Context."""
SIMULATION = ["simulation:SimulationPart"]
"""Parts of the whole simulation.  The parts are created with a Context."""


def part_class(entry: str) -> Any:
    """Return the class to which an entry refers."""
    module, _, name = entry.partition(":")
    return getattr(import_module(f"tool0_ros2.{module}"), name)
