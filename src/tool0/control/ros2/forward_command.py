"""forward_command_controller: commands are passed on to the joints as they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, final

from tool0.control.held_commands import HeldPositions, checked_commands
from tool0.control.law import CommandLaw
from tool0.control.parameters import (
    INTERFACE_OF_PACKAGE,
    RobotJoints,
    controlled_joint,
    controlled_joints,
)
from tool0.control.trajectory import Setpoint
from tool0.description.model import Interface, Joint
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, did_you_mean
from tool0.hardware.engine import JointState, joint_selector
from tool0.protocol.controllers import Gains

_INTERFACES = {item.name.lower(): item for item in Interface}


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ForwardCommandSpec:
    """The parameters of a ForwardCommandController, or of a JointGroup…Controller."""

    name: str
    type: str
    joint_models: tuple[Joint, ...]
    interface: Interface

    gains: ClassVar[tuple[Gains, ...]] = ()
    further_interfaces: ClassVar[tuple[str, ...]] = ()
    state_interfaces: ClassVar[tuple[str, ...]] = ()

    @property
    def joints(self) -> tuple[str, ...]:
        return tuple(joint.name for joint in self.joint_models)

    @property
    def waits_for_command(self) -> bool:
        """Whether nothing is written before the first command.

        The brakes hold until then.  A servo of positions holds as well, and so does one
        of velocities.
        """
        return self.interface is Interface.EFFORT

    def start(
        self, indices: Sequence[int], state: JointState
    ) -> ForwardCommandController:
        return ForwardCommandController(self, indices, state)


@final
class ForwardCommandController:
    """Pass the newest command on; before the first one, the joints stay as they are."""

    pid: ClassVar[None] = None

    def __init__(
        self, spec: ForwardCommandSpec, indices: Sequence[int], state: JointState
    ) -> None:
        self.spec = spec
        self._select = joint_selector(indices)
        self._held = HeldPositions(spec.joint_models, self._select)
        self._state = state
        self._is_position = spec.interface is Interface.POSITION
        self._command = (
            list(self._select(state.position))
            if self._is_position
            else [0.0] * len(indices)
        )

    def update(self, state: JointState, period: float) -> Sequence[float]:
        """Return the commands."""
        self._state = state
        return self._command

    def law(self) -> CommandLaw:
        no_errors = [0.0] * len(self._command)
        return CommandLaw(self._command, None, not self._is_position, (), no_errors)

    def observe(self, state: JointState) -> None:
        self._state = state

    def command_joints(self, values: Sequence[float] | float) -> None:
        """Set one command per joint, in the order of the controller's joints.

        Raises:
            ControlError: If the count is wrong or a number is not finite; the last
                command stays.
        """
        spec = self.spec
        joints = spec.joints
        self._command = checked_commands(
            values,
            len(joints),
            wrong_size=lambda size: (
                f"command size ({size}) does not match number of interfaces "
                f"({len(joints)}) of '{spec.name}': {', '.join(joints)}"
            ),
            not_finite=lambda k, value: (
                f"Non-finite value received. Dropping message: {value} for joint "
                f"'{joints[k]}' of '{spec.name}'"
            ),
        )
        self._held.command(self._command)

    def setpoint(self) -> Setpoint | None:
        """Return the positions that were commanded, if positions were."""
        return self._held.setpoint(self._state) if self._is_position else None

    def stop(self) -> None:
        """Do nothing: there is no goal to end."""


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
        parameters.text("interface_name", interface.name.lower())  # it is fixed
        joints = controlled_joints(robot, parameters, interface)
    return ForwardCommandSpec(
        name=name, type=type_name, joint_models=joints, interface=interface
    )


def _interface(parameters: Namespace, path: str, names: Sequence[str]) -> Interface:
    """Return the one command interface that is named."""
    entry = parameters.find(path) or parameters.entry
    for name in names:
        if name not in _INTERFACES:
            raise ConfigError(
                f"'{entry.key}': joints have no command interface '{name}'"
                + did_you_mean(name, _INTERFACES),
                entry.location,
            )
    if len(names) > 1:
        raise ConfigError(
            f"'{entry.key}' names {' and '.join(names)}, but a drive follows one "
            "command interface at a time; name one",
            entry.location,
        )
    return _INTERFACES[names[0]]
