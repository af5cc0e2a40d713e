"""The parameters of forward_command_controller in ROS 2."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from tool0.control.forward_command import CommandWording, ForwardCommandSpec
from tool0.control.parameters import (
    INTERFACE_OF_NAME,
    INTERFACE_OF_PACKAGE,
    RobotJoints,
    controlled_joint,
    controlled_joints,
)
from tool0.description.model import Interface, Joint
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, did_you_mean

_WORDING: Final = CommandWording(
    wrong_size="command size ({size}) does not match number of interfaces "
    "({n_joints}) of '{controller}': {joints}",
    not_finite="Non-finite value received. Dropping message: {value} for joint "
    "'{joint}' of '{controller}'",
)


def parse(
    name: str, type_name: str, parameters: Namespace, robot: RobotJoints
) -> ForwardCommandSpec:
    """Return the checked parameters of a forwarding controller."""
    package, _, kind = type_name.partition("/")
    joints: tuple[Joint, ...]
    if kind == "MultiInterfaceForwardCommandController":
        joint_name = parameters.text("joint")
        names = parameters.texts("interface_names")
        interface = _interface(parameters, "interface_names", names)
        entry = parameters.find("joint") or parameters.entry
        joints = (controlled_joint(robot, joint_name, interface, entry),)
    elif package == "forward_command_controller":
        names = (parameters.text("interface_name"),)
        interface = _interface(parameters, "interface_name", names)
        joints = controlled_joints(robot, parameters, interface)
    else:
        interface = INTERFACE_OF_PACKAGE[package]
        parameters.text("interface_name", interface.name.lower())  # the value is fixed
        joints = controlled_joints(robot, parameters, interface)
    return ForwardCommandSpec(
        name=name,
        type=type_name,
        joint_models=joints,
        interface=interface,
        quantity=interface,
        wording=_WORDING,
    )


def _interface(parameters: Namespace, path: str, names: Sequence[str]) -> Interface:
    """Return the single command interface that the parameters specify."""
    entry = parameters.find(path) or parameters.entry
    for name in names:
        if name not in INTERFACE_OF_NAME:
            raise ConfigError(
                f"'{entry.key}': joints have no command interface '{name}'"
                + did_you_mean(name, INTERFACE_OF_NAME),
                entry.location,
            )
    if len(names) > 1:
        raise ConfigError(
            f"'{entry.key}' names {' and '.join(names)}, but a drive follows one "
            "command interface at a time; name one",
            entry.location,
        )
    return INTERFACE_OF_NAME[names[0]]
