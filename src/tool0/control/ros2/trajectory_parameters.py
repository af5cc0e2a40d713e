"""The parameters that JointTrajectoryController declares in ROS 2.

``allow_trajectory_replacement`` has the default of ROS 2 Lyrical.  With ``false``, the
controller behaves as it does in Jazzy and Kilted, which do not have
``allow_trajectory_replacement``.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence

from tool0.control.parameters import (
    INTERFACE_OF_NAME,
    RobotJoints,
    controlled_joints,
    read_at_least,
    read_tolerances,
)
from tool0.control.ros2.joint_trajectory import JointTrajectorySpec
from tool0.control.ros2.trajectory_check import Acceptance
from tool0.control.ros2.trajectory_gains import choice, read_joint_gains
from tool0.control.ros2.trajectory_settings import Replacement, SpeedSource
from tool0.control.tolerances import TrajectoryTolerances
from tool0.description.model import Interface, Joint
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, did_you_mean
from tool0.protocol.controllers import Gains

logger = logging.getLogger(__name__)

_STATES = ("position", "velocity", "acceleration")
_COMMANDS = (*_STATES, "effort")
SPEED_SCALING = "speed_scaling/speed_scaling_factor"
"""Name of the state interface with an arm's speed factor, without the arm's prefix."""
_ADJUSTABLE = (
    "allow_partial_joints_goal",
    "allow_trajectory_replacement",
    "allow_integration_in_goal_trajectories",
    "allow_nonzero_velocity_at_trajectory_end",
    "positions_upsampling/policy_frequency",
    "cmd_timeout",
    "constraints/stopped_velocity_tolerance",
    "constraints/goal_time",
)


def parse(
    name: str, type_name: str, parameters: Namespace, robot: RobotJoints
) -> JointTrajectorySpec:
    """Return the checked parameters of a JointTrajectoryController."""
    commands = _choices(parameters, "command_interfaces", _COMMANDS)
    interface = _command_interface(parameters, commands)
    joints = controlled_joints(robot, parameters, interface)
    states = read_states(parameters, robot, joints, interface)
    _check_command_joints(parameters, joints)
    is_open_loop = parameters.boolean("open_loop_control", default=False)
    gains, velocity_ff = read_joint_gains(parameters, joints)
    if interface is Interface.POSITION:
        gains, velocity_ff = (), ()
    elif interface is Interface.VELOCITY and is_open_loop:
        gains, velocity_ff = (Gains(p=0.0),) * len(joints), (1.0,) * len(joints)
    goal_time = parameters.not_negative("constraints/goal_time", 0.0)
    tolerances = TrajectoryTolerances(
        joints=read_tolerances(parameters, joints, robot),
        goal_time=goal_time or math.inf,  # 0 means no limit
    )
    # The parameter has no effect, since the brakes hold the measured position while no
    # controller is active.
    parameters.boolean("set_last_command_interface_value_as_state_on_activation", True)
    parameters.mark_adjustable(
        *_ADJUSTABLE,
        *(
            f"constraints/{joint.name}/{kind}"
            for joint in joints
            for kind in ("trajectory", "goal")
        ),
    )
    scaling = _speed_interface(type_name, parameters, robot)
    return JointTrajectorySpec(
        name=name,
        type=type_name,
        joint_models=joints,
        interface=interface,
        further_interfaces=tuple(
            f"{joint.name}/{kind}" for joint in joints for kind in commands[1:]
        ),
        state_interfaces=(
            *(f"{joint.name}/{kind}" for joint in joints for kind in states),
            *(() if scaling is None else (f"{scaling}{SPEED_SCALING}",)),
        ),
        gains=gains,
        velocity_ff=velocity_ff,
        judges_velocity="velocity" in states and commands != ("position",),
        reads_velocity="velocity" in states,
        acceptance=Acceptance(
            tuple(joint.name for joint in joints),
            parameters.boolean("allow_partial_joints_goal", default=False),
            parameters.boolean(
                "allow_nonzero_velocity_at_trajectory_end", default=False
            ),
            parameters.boolean("allow_integration_in_goal_trajectories", default=False),
        ),
        tolerances=tolerances,
        deceleration=_deceleration(parameters, joints, states),
        command_timeout=_command_timeout(parameters, goal_time),
        replacement=_replacement(parameters, is_open_loop=is_open_loop),
        speed=SpeedSource(
            initial=parameters.not_negative("speed_scaling/initial_scaling_factor", 1.0)
            if commands == ("position",)
            else 1.0,
            is_settable=commands == ("position",),
            factors=robot.speed_scaling,
            prefix=scaling,
        ),
        state_publish_rate=parameters.not_negative("state_publish_rate", 50.0),
        action_monitor_rate=read_at_least(parameters, "action_monitor_rate", 20.0, 0.1),
    )


# ---- interfaces ----------------------------------------------------------------------


def _choices(parameters: Namespace, path: str, valid: Sequence[str]) -> tuple[str, ...]:
    """Return the kinds of interfaces that a parameter lists.

    The parameter must not list an interface twice.
    """
    kinds = parameters.texts(path)
    entry = parameters.find(path)
    for kind, item in zip(kinds, entry.items if entry else (), strict=True):
        if kind not in valid:
            raise ConfigError(
                f"'{item.key}' is '{kind}', which is not an interface type"
                + did_you_mean(kind, valid),
                item.location,
            )
        if kinds.count(kind) > 1:
            raise ConfigError(f"'{item.key}' names '{kind}' twice", item.location)
    return kinds


def _command_interface(parameters: Namespace, kinds: tuple[str, ...]) -> Interface:
    """Return the interface that drives the joints.

    The other interfaces are only claimed.
    """
    for offered in (("position", "velocity"), *((kind,) for kind in INTERFACE_OF_NAME)):
        if sorted(kinds) == sorted(offered):
            return INTERFACE_OF_NAME[offered[0]]
    entry = parameters.find("command_interfaces") or parameters.entry
    raise ConfigError(
        f"'{entry.key}' cannot be [{', '.join(kinds)}]: use [position], "
        "[position, velocity], [velocity] or [effort]",
        entry.location,
    )


def read_states(
    parameters: Namespace,
    robot: RobotJoints,
    joints: Sequence[Joint],
    interface: Interface,
) -> tuple[str, ...]:
    """Return the kinds of state interfaces that ``state_interfaces`` lists.

    Raises:
        ConfigError: If a joint lacks a listed interface, or the list lacks an interface
            that a controller of ``interface`` needs.
    """
    kinds = _choices(parameters, "state_interfaces", _STATES)
    entry = parameters.find("state_interfaces") or parameters.entry
    if "position" not in kinds:
        raise ConfigError(
            f"'{entry.key}' lacks 'position': every trajectory starts with it",
            entry.location,
        )
    if interface is not Interface.POSITION and "velocity" not in kinds:
        raise ConfigError(
            f"'{interface.name.lower()}' command interface can only be used alone if "
            f"'velocity' and 'position' state interfaces are present; '{entry.key}' "
            "lacks 'velocity'",
            entry.location,
        )
    for joint in joints:
        for kind in kinds:
            if f"{joint.name}/{kind}" not in robot.joint_states:
                raise ConfigError(
                    f"joint '{joint.name}' has no state interface '{kind}', which "
                    f"'{entry.key}' requires",
                    entry.location,
                )
    return kinds


def _check_command_joints(parameters: Namespace, joints: Sequence[Joint]) -> None:
    names = [joint.name for joint in joints]
    given = parameters.texts("command_joints", ())
    entry = parameters.find("command_joints")
    if entry is not None and given and list(given) != names:
        raise ConfigError(
            f"'{entry.key}' must be empty or name the same joints as 'joints', in the "
            "same order: joints that are only watched are not supported",
            entry.location,
        )


def _speed_interface(
    type_name: str, parameters: Namespace, robot: RobotJoints
) -> str | None:
    """Return the prefix of the arm with the applicable speed scaling, or None."""
    path, default = "speed_scaling/state_interface", ""
    if type_name.endswith("/ScaledJointTrajectoryController"):
        path = "speed_scaling_interface_name"
        default = parameters.text("tf_prefix", "") + SPEED_SCALING
    parameters.accept("speed_scaling/command_interface", "speed_scaling_topic_name")
    name = parameters.text(path, default)
    return speed_prefix(parameters, path, name, robot) if name else None


def speed_prefix(
    parameters: Namespace, path: str, name: str, robot: RobotJoints
) -> str:
    """Return the prefix of the arm with the named interface for speed scaling.

    Raises:
        ConfigError: If no arm has the state interface ``name``, which is the value of
            the parameter at ``path``.
    """
    valid = [f"{prefix}{SPEED_SCALING}" for prefix in robot.speed_scaling or ("",)]
    if name not in valid:
        entry = parameters.find(path) or parameters.entry
        raise ConfigError(
            f"'{entry.key}': the robot has no state interface '{name}'"
            + did_you_mean(name, valid),
            entry.location,
        )
    return name.removesuffix(SPEED_SCALING)


# ---- constraints and replacement -----------------------------------------------------


def _deceleration(
    parameters: Namespace, joints: Sequence[Joint], states: Sequence[str]
) -> tuple[float, ...]:
    """Return the deceleration of each joint in a stop [rad/s² | m/s²].

    The result is empty if the joints hold their measured positions instead.
    """
    rates = tuple(
        parameters.not_negative(
            f"constraints/{joint.name}/max_deceleration_on_cancel", 0.0
        )
        for joint in joints
    )
    if not parameters.boolean("constraints/decelerate_on_cancel", default=False):
        return ()
    for joint, rate in zip(joints, rates, strict=True):
        wrong = ""
        if not rate > 0.0:
            wrong = f"invalid max_deceleration_on_cancel [{rate:.1f}]"
        elif not 0.0 < joint.limits.velocity < math.inf:
            wrong = "no joint velocity defined in URDF"
        elif "velocity" not in states:
            wrong = "no velocity state interface"
        if wrong:
            logger.error(
                "Joint [%s] has %s. Falling back to hold position on cancel.",
                joint.name,
                wrong,
            )
            return ()
    return rates


def _command_timeout(parameters: Namespace, goal_time: float) -> float:
    """Return the time after which the position is held [s]; inf for no timeout."""
    timeout = parameters.number("cmd_timeout", 0.0)
    if timeout > goal_time:
        return timeout
    if timeout > 0.0:
        logger.warning(
            "Command timeout must be higher than goal_time tolerance (%f vs. %f)",
            timeout,
            goal_time,
        )
    return math.inf


def _replacement(parameters: Namespace, *, is_open_loop: bool) -> Replacement:
    methods = "splines", "none"
    is_stepped = choice(parameters, "interpolation_method", methods) == "none"
    return Replacement(
        is_spliced=parameters.boolean("allow_trajectory_replacement", default=True),
        from_desired=parameters.boolean("interpolate_from_desired_state", default=False)
        or is_open_loop,
        is_stepped=is_stepped,
        upsamples=parameters.boolean("positions_upsampling/enable", default=False)
        and not is_stepped,
        policy_frequency=parameters.not_negative(
            "positions_upsampling/policy_frequency", 0.0
        ),
    )
