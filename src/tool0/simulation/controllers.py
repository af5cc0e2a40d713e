"""Choice of the controllers that a bring-up loads and starts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from tool0.control.config import ControllerConfig
from tool0.control.default_controllers import (
    PERIOD,
    controller_prefixes,
    default_controllers,
)
from tool0.control.parameters import RobotJoints
from tool0.control.ros2.built_in import started as started_controllers
from tool0.control.ros2.dialect import ROS2
from tool0.control.starting import choose
from tool0.description.finding import Finding, quoted, warning_at
from tool0.description.parts import arm_joints
from tool0.description.robot import RobotDescription
from tool0.errors import ConfigError, SourceLocation, did_you_mean
from tool0.simulation.config import ControlConfig, Names
from tool0.user_data import expanded

DEFAULT_CONTROLLERS = (
    "joint_state_controller",
    "eff_joint_traj_controller",
    "pos_joint_traj_controller",
    "gripper_controller",
)
DEFAULT_STOPPED_CONTROLLERS = (
    "joint_group_eff_controller",
    "joint_group_pos_controller",
)
"""ROS 1 controllers that are loaded but not started, as in the launch file
``ur5_bringup.launch``, if the YAML defines these controllers.  In a cell, each robot
has its own controllers, with names that start with the robot's name."""


UNSCALED = "joint_trajectory_controller"
SCALED = "scaled_joint_trajectory_controller"

_CHOOSE = "choose with --controllers 'NAME ...' (in Python: controllers=)"


class ControllerChoice(NamedTuple):
    """The controllers of a bring-up."""

    config: ControllerConfig
    started: tuple[str, ...]
    stopped: tuple[str, ...]
    """Names of the controllers to load but not to start."""
    findings: tuple[Finding, ...]
    """Warnings about joints that no controller moves; empty if the options specify the
    controllers."""


def choose_controllers(
    description: RobotDescription, control: ControlConfig, *, is_real: bool = False
) -> ControllerChoice:
    """Return the controllers that the options specify, or the default controllers.

    If the user provides a YAML file, all of its controllers that drive joints
    unambiguously are also started.  On a real robot (``is_real``), the default is the
    controller that follows the robot's speed slider.

    Raises:
        ConfigError: If the YAML is invalid or does not define one of the names.
    """
    config = _config(description, control)
    prefixes = ("", *controller_prefixes(description))
    to_start, to_stop = _defaults(description, control, config)
    if is_real and SCALED in to_stop:
        swap = {UNSCALED: SCALED, SCALED: UNSCALED}
        to_start = [swap.get(name, name) for name in to_start]
        to_stop = [swap.get(name, name) for name in to_stop]
    started = _existing(config, control.controllers, to_start, prefixes)
    stopped = _existing(config, control.stopped_controllers, to_stop, prefixes)
    findings = []
    if control.controllers_file is not None and control.controllers is None:
        robot = _joints_of(description)
        choice = choose(config, robot, usual=started, not_to_start=stopped)
        started += choice.started
        here = _file_of(config)
        findings = [
            warning_at(here, "not-started", "", reason, _CHOOSE)
            for reason in choice.reasons
        ]
    return ControllerChoice(
        config,
        started,
        tuple(name for name in stopped if name not in started),
        (*findings, *_findings(description, control, config, started)),
    )


def _joints_of(description: RobotDescription) -> RobotJoints:
    model = description.model
    return RobotJoints(
        {joint.name: joint for joint in model.movable_joints},
        {item.joint: item.interfaces for item in model.transmissions},
        hardware=model.hardware,
        grippers=model.grippers,
        arms=arm_joints(model),
    )


def _file_of(config: ControllerConfig) -> SourceLocation:
    """Return the last file that defines a controller."""
    entries = list(config.tree.root.children.values())
    return SourceLocation(entries[-1].location.file if entries else None)


def _defaults(
    description: RobotDescription, control: ControlConfig, config: ControllerConfig
) -> tuple[Sequence[str], Sequence[str]]:
    """Return the default controllers to start, and the controllers to load only."""
    if config.dialect is not ROS2:
        return DEFAULT_CONTROLLERS, DEFAULT_STOPPED_CONTROLLERS
    usual = started_controllers()
    if control.controllers_file is not None or not description.robots:
        return usual.always, ()
    return (*usual.always, *usual.built_in), usual.loaded


def _config(description: RobotDescription, control: ControlConfig) -> ControllerConfig:
    files = control.controllers_file
    if files is None:
        return default_controllers(
            description,
            gripper_action=control.gripper_action,
            period=control.control_period or PERIOD,
        )
    if control.gripper_action:
        raise ConfigError(
            "gripper_action is for the built-in controllers, and controllers_file "
            "replaces them; leave out one of the two"
        )
    given = [files] if isinstance(files, Path | str) else files
    paths = [expanded(file) for file in given]
    return ControllerConfig.from_files(paths, description.arguments)


def _existing(
    config: ControllerConfig,
    names: Names | None,
    default: Sequence[str],
    prefixes: Sequence[str],
) -> tuple[str, ...]:
    """Return the given names, or the default names that are defined.

    The given names must be defined.
    """
    defined = config.names
    if names is None:
        usual = dict.fromkeys(prefix + name for prefix in prefixes for name in default)
        return tuple(name for name in usual if name in defined)
    given = tuple(names.split() if isinstance(names, str) else names)
    for name in given:
        if name not in defined:
            hint = did_you_mean(name, set(defined))
            raise ConfigError(f"no controller '{name}' in the YAML{hint}")
    return given


def _findings(
    description: RobotDescription,
    control: ControlConfig,
    config: ControllerConfig,
    started: tuple[str, ...],
) -> list[Finding]:
    """Return a warning if no joint can move.

    There is no warning if the options specify the controllers.
    """
    here = SourceLocation(description.source)
    driven = [item.joint for item in description.model.transmissions]
    if not driven:
        problem = (
            "the robot has no driven joint: no <transmission> or <ros2_control> names "
            "one"
        )
        remedy = (
            "add one for each joint that a motor moves, or use --ros2 (in Python: "
            "ros2_control=True), which drives every joint"
        )
        return [warning_at(here, "no-driven-joint", "", problem, remedy)]
    chosen = (control.controllers, control.stopped_controllers)
    if started or chosen != (None, None):
        return []
    if config.names:
        problem = f"no controller is started; the YAML defines {quoted(config.names)}"
        remedy = _CHOOSE
    else:
        problem = f"no controller is loaded: no built-in one fits {quoted(driven)}"
        remedy = (
            "pass your own with --controllers-file FILE --controllers 'NAME ...' "
            "(in Python: controllers_file=, controllers=)"
        )
    problem += "; brakes hold the joints"
    return [warning_at(here, "no-controller", "", problem, remedy)]
