"""Which controllers a bring-up loads and starts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from tool0.control.config import ControllerConfig
from tool0.control.parameters import RobotJoints
from tool0.description.config import File
from tool0.description.default_controllers import (
    all_default_controllers,
    default_controllers,
)
from tool0.description.finding import Finding, quoted, warning_at
from tool0.description.model import RobotModel
from tool0.description.robot import RobotDescription
from tool0.errors import ConfigError, SourceLocation, did_you_mean
from tool0.runtime.config import ControlConfig, Names
from tool0.user_data import expanded

DEFAULT_CONTROLLERS = (
    "joint_state_controller",
    "eff_joint_traj_controller",
    "gripper_controller",
)
DEFAULT_STOPPED_CONTROLLERS = ("joint_group_eff_controller",)
"""As in the launch file ``ur5_bringup.launch``; only those that the YAML defines."""


class ControllerChoice(NamedTuple):
    """The controllers of a bring-up."""

    config: ControllerConfig
    started: tuple[str, ...]
    stopped: tuple[str, ...]
    """To be loaded, not started."""
    findings: tuple[Finding, ...]
    """A warning if nothing can move, unless the options request it."""


def choose_controllers(
    description: RobotDescription, control: ControlConfig
) -> ControllerChoice:
    """Return the controllers that the options name, or the default ones.

    Raises:
        ConfigError: If the YAML does not define one of the names, or is wrong.
    """
    config = _config(description, control.controllers_file)
    started = _existing(
        config, control.controllers, _of_all(description, DEFAULT_CONTROLLERS)
    )
    stopped = _existing(
        config,
        control.stopped_controllers,
        _of_all(description, DEFAULT_STOPPED_CONTROLLERS),
    )
    return ControllerChoice(
        config,
        started,
        tuple(name for name in stopped if name not in started),
        tuple(_findings(description, control, config, started)),
    )


def _of_all(description: RobotDescription, names: tuple[str, ...]) -> tuple[str, ...]:
    prefixes = [f"{robot.name}_" for robot in description.robots if robot.name]
    return (*names, *(prefix + name for prefix in prefixes for name in names))


def _config(
    description: RobotDescription, files: File | Sequence[File] | None
) -> ControllerConfig:
    if files is not None:
        given = [files] if isinstance(files, Path | str) else files
        return ControllerConfig.from_files([expanded(file) for file in given])
    if description.robots:
        return ControllerConfig.from_text(*default_controllers(description))
    for text, location in all_default_controllers():
        config = ControllerConfig.from_text(text, location)
        if _fits(config, description.model):
            return config
    return ControllerConfig.from_text("")


def _fits(config: ControllerConfig, model: RobotModel) -> bool:
    """Return whether a robot has the joints of the default controllers."""
    interfaces = {item.joint: item.interface for item in model.transmissions}
    robot = RobotJoints(model.joint_by_name, interfaces)
    try:
        for name in _existing(config, None, DEFAULT_CONTROLLERS):
            config.spec(name, robot)
    except ConfigError:
        return False
    return True


def _existing(
    config: ControllerConfig, names: Names | None, default: tuple[str, ...]
) -> tuple[str, ...]:
    """Return the names, which must be defined, or the default ones that are."""
    defined = config.names
    if names is None:
        return tuple(name for name in default if name in defined)
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
    """Return a warning if nothing can move, unless the options request it."""
    here = SourceLocation(description.source)
    driven = [item.joint for item in description.model.transmissions]
    if not driven:
        problem = "the robot has no driven joint: no <transmission> names one"
        remedy = "add a <transmission> for each joint that a motor moves"
        return [warning_at(here, "no-driven-joint", "", problem, remedy)]
    chosen = (control.controllers, control.stopped_controllers)
    if started or chosen != (None, None):
        return []
    if config.names:
        problem = f"no controller is started; the YAML defines {quoted(config.names)}"
        remedy = "choose with --controllers 'NAME ...' (in Python: controllers=)"
    else:
        problem = f"no controller is loaded: no built-in one fits {quoted(driven)}"
        remedy = (
            "pass your own with --controllers-file FILE --controllers 'NAME ...' "
            "(in Python: controllers_file=, controllers=)"
        )
    problem += "; brakes hold the joints"
    return [warning_at(here, "no-controller", "", problem, remedy)]
