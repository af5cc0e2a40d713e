"""Which parameters each controller type reads, for the linter.

``*`` stands for a joint of the controller.
"""

from __future__ import annotations

from collections.abc import Mapping

GAINS = frozenset(
    {
        "p",
        "i",
        "d",
        "i_clamp",
        "i_clamp_min",
        "i_clamp_max",
        "antiwindup",
        "publish_state",
    }
)

_TRAJECTORY = frozenset(
    {
        "joints",
        "constraints/goal_time",
        "constraints/stopped_velocity_tolerance",
        "constraints/*/trajectory",
        "constraints/*/goal",
        "stop_trajectory_duration",
        "allow_partial_joints_goal",
        "state_publish_rate",
        "action_monitor_rate",
    }
)
_GRIPPER = frozenset(
    {
        "joint",
        "goal_tolerance",
        "max_effort",
        "stall_velocity_threshold",
        "stall_timeout",
        "allow_stalling",
        "action_monitor_rate",
    }
)
_JOINT_STATE = frozenset({"joints", "publish_rate", "extra_joints"})
_GAINS_BY_JOINT = frozenset({f"gains/*/{name}" for name in GAINS})
_PID = frozenset({f"pid/{name}" for name in GAINS})
_PID_BY_JOINT = frozenset({f"*/pid/{name}" for name in GAINS})

_TYPES: Mapping[str, frozenset[str]] = {
    "joint_state_controller/JointStateController": _JOINT_STATE,
    "position_controllers/JointTrajectoryController": _TRAJECTORY,
    "velocity_controllers/JointTrajectoryController": (
        _TRAJECTORY | _GAINS_BY_JOINT | {"velocity_ff/*"}
    ),
    "effort_controllers/JointTrajectoryController": (
        _TRAJECTORY | _GAINS_BY_JOINT | {"velocity_ff/*"}
    ),
    "position_controllers/GripperActionController": _GRIPPER,
    "effort_controllers/GripperActionController": _GRIPPER | _GAINS_BY_JOINT,
    "effort_controllers/JointEffortController": frozenset({"joint"}),
    "effort_controllers/JointPositionController": frozenset({"joint"}) | _PID,
    "effort_controllers/JointVelocityController": frozenset({"joint"}) | _PID,
    "effort_controllers/JointGroupEffortController": frozenset({"joints"}),
    "effort_controllers/JointGroupPositionController": (
        frozenset({"joints"}) | _PID_BY_JOINT
    ),
    "position_controllers/JointPositionController": frozenset({"joint"}),
    "position_controllers/JointGroupPositionController": frozenset({"joints"}),
    "velocity_controllers/JointPositionController": frozenset({"joint"}) | _PID,
    "velocity_controllers/JointVelocityController": frozenset({"joint"}),
    "velocity_controllers/JointGroupVelocityController": frozenset({"joints"}),
}

LIMITS = frozenset(
    {
        "has_position_limits",
        "min_position",
        "max_position",
        "has_velocity_limits",
        "max_velocity",
        "has_acceleration_limits",
        "max_acceleration",
        "has_jerk_limits",
        "max_jerk",
        "has_effort_limits",
        "max_effort",
        "angle_wraparound",
    }
)
"""What ros_control reads under ``joint_limits/<joint>``."""


def parameters_of(type_name: str) -> frozenset[str]:
    """Return the patterns of the parameters that a type reads, besides ``type``."""
    return _TYPES[type_name]


def readers_of(pattern: str) -> tuple[str, ...]:
    """Return the kinds of controllers that read a parameter, without packages."""
    return tuple(
        sorted(
            {
                name.partition("/")[2]
                for name, patterns in _TYPES.items()
                if pattern in patterns
            }
        )
    )
