"""The parameters of ``Joint…Controller`` and ``JointGroup…Controller`` in ROS 1."""

from __future__ import annotations

from typing import Final

from tool0.control.forward_command import CommandWording, ForwardCommandSpec
from tool0.control.parameters import (
    INTERFACE_OF_PACKAGE,
    RobotJoints,
    controlled_joints,
    read_gains,
    single_joint,
)
from tool0.description.model import Interface
from tool0.description.yaml_values import Namespace
from tool0.protocol.controllers import Gains

_WORDING: Final = CommandWording(
    wrong_size="Dimension of command ({size}) does not match number of joints "
    "({n_joints}) of '{controller}': {joints}. Not executing!",
    not_finite="command {value} for joint '{joint}' of '{controller}'; "
    "it must be a finite number",
)


def parse(
    name: str, type_name: str, parameters: Namespace, robot: RobotJoints
) -> ForwardCommandSpec:
    """Return the checked parameters of a forwarding controller."""
    package, _, kind = type_name.partition("/")
    interface = INTERFACE_OF_PACKAGE[package]
    is_group = kind.startswith("JointGroup")
    quantity = Interface[kind[10 if is_group else 5 : -len("Controller")].upper()]
    if is_group:
        joints = controlled_joints(robot, parameters, interface)
    else:
        joints = (single_joint(robot, parameters, interface),)
    gains: tuple[Gains, ...] = ()
    if quantity is not interface:
        paths = [f"{joint.name}/pid" for joint in joints] if is_group else ["pid"]
        why = f"{type_name} needs"
        gains = tuple(read_gains(parameters, path, why) for path in paths)
    return ForwardCommandSpec(
        name=name,
        type=type_name,
        joint_models=joints,
        interface=interface,
        quantity=quantity,
        gains=gains,
        wording=_WORDING,
    )
