"""Which parameters the controllers of ros2_control read.

``*`` stands for a joint.  Source: the parameter declarations of ros2_controllers, from
Humble to Rolling, and of ur_controllers; a parameter of any of them counts as known.
"""

from __future__ import annotations

from collections.abc import Mapping


def _names(words: str) -> frozenset[str]:
    return frozenset(words.split())


COMMON = _names(
    "type update_rate is_async use_sim_time params_file fallback_controllers"
    " node_options_args thread_priority async_parameters/* qos_overrides/*"
    " start_type_description_service"
)
"""Parameters of every controller."""
MANAGER = _names(
    "update_rate use_sim_time robot_description handle_exceptions"
    " enforce_command_limits thread_priority lock_memory cpu_affinity"
    " shutdown_on_initial_state_failure hardware_components_initial_state defaults"
    " diagnostics overruns qos_overrides services start_type_description_service"
)
"""Parameters of the controller manager itself."""

_GAINS = frozenset(
    f"gains/*/{name}"
    for name in _names(
        "p i d i_clamp i_clamp_min i_clamp_max u_clamp_min u_clamp_max antiwindup"
        " antiwindup_strategy tracking_time_constant error_deadband saturation"
        " ff_velocity_scale angle_wraparound normalize_error save_i_term"
    )
)
_TRAJECTORY = _GAINS | _names(
    "joints command_joints command_interfaces state_interfaces"
    " allow_partial_joints_goal open_loop_control interpolate_from_desired_state"
    " allow_integration_in_goal_trajectories allow_nonzero_velocity_at_trajectory_end"
    " allow_trajectory_replacement"
    " set_last_command_interface_value_as_state_on_activation action_monitor_rate"
    " state_publish_rate interpolation_method cmd_timeout positions_upsampling"
    " speed_scaling speed_scaling_interface_name speed_scaling_topic_name tf_prefix"
    " constraints/goal_time constraints/stopped_velocity_tolerance"
    " constraints/decelerate_on_cancel constraints/*/trajectory constraints/*/goal"
    " constraints/*/max_deceleration_on_cancel"
)
_GRIPPER = _GAINS | _names(
    "joint action_monitor_rate goal_tolerance max_effort allow_stalling"
    " stall_velocity_threshold stall_timeout"
)
_PARALLEL_GRIPPER = _GRIPPER | _names(
    "max_effort_interface max_velocity_interface max_velocity state_interfaces"
)
_GROUP = _names("joints interface_name")

TYPES: Mapping[str, frozenset[str]] = {
    "joint_trajectory_controller/JointTrajectoryController": _TRAJECTORY,
    "ur_controllers/ScaledJointTrajectoryController": _TRAJECTORY,
    "joint_state_broadcaster/JointStateBroadcaster": _names(
        "joints interfaces extra_joints use_local_topics use_urdf_to_filter"
        " map_interface_to_joint_state frame_id publish_dynamic_joint_states"
    ),
    "forward_command_controller/ForwardCommandController": _GROUP,
    "forward_command_controller/MultiInterfaceForwardCommandController": _names(
        "joint interface_names"
    ),
    "position_controllers/JointGroupPositionController": _GROUP,
    "velocity_controllers/JointGroupVelocityController": _GROUP,
    "effort_controllers/JointGroupEffortController": _GROUP,
    "position_controllers/GripperActionController": _GRIPPER,
    "effort_controllers/GripperActionController": _GRIPPER,
    "parallel_gripper_action_controller/GripperActionController": _PARALLEL_GRIPPER,
}
"""The parameters of each controller that is known."""

OTHER_TYPES = _names(
    "force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster"
    " imu_sensor_broadcaster/IMUSensorBroadcaster"
    " pose_broadcaster/PoseBroadcaster"
    " range_sensor_broadcaster/RangeSensorBroadcaster"
    " admittance_controller/AdmittanceController"
    " diff_drive_controller/DiffDriveController"
    " pid_controller/PidController"
    " gpio_controllers/GpioCommandController"
    " ur_controllers/SpeedScalingStateBroadcaster"
    " ur_controllers/ForceTorqueStateBroadcaster"
    " ur_controllers/GPIOController"
    " ur_controllers/PassthroughTrajectoryController"
    " ur_controllers/FreedriveModeController"
    " ur_controllers/ForceModeController"
    " ur_controllers/ToolContactController"
    " ur_controllers/FrictionModelController"
    " ur_controllers/GravityUpdateController"
    " ur_controllers/URConfigurationController"
)
"""Controllers that exist, whose parameters are not checked."""


def required_parameters(type_name: str) -> tuple[str, ...]:
    """Return the parameters that a controller needs to configure."""
    package, _, kind = type_name.partition("/")
    if kind.endswith("JointTrajectoryController"):
        return ("joints", "command_interfaces", "state_interfaces")
    if kind == "MultiInterfaceForwardCommandController":
        return ("joint", "interface_names")
    if package == "forward_command_controller":
        return ("joints", "interface_name")
    if kind.startswith("JointGroup"):
        return ("joints",)
    return ("joint",) if kind == "GripperActionController" else ()
