"""Controllers that take one number per joint: forwarded, or followed by a PID."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, final

from tool0.control.held_commands import HeldPositions, checked_commands
from tool0.control.law import CommandLaw
from tool0.control.parameters import (
    INTERFACE_OF_PACKAGE,
    Pid,
    RobotJoints,
    controlled_joints,
    read_gains,
    single_joint,
)
from tool0.control.spline import shortest_turn
from tool0.control.trajectory import Setpoint
from tool0.description.model import Interface, Joint, JointType
from tool0.description.yaml_values import Namespace
from tool0.hardware.engine import JointState, joint_selector
from tool0.protocol.controllers import Gains


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ForwardCommandSpec:
    """A ``Joint…Controller`` or ``JointGroup…Controller``."""

    name: str
    type: str
    joint_models: tuple[Joint, ...]
    interface: Interface
    quantity: Interface
    """The interface that takes its commands unchanged."""
    gains: tuple[Gains, ...] = ()
    """One per joint if the quantity is not the interface's own."""

    further_interfaces: ClassVar[tuple[str, ...]] = ()
    state_interfaces: ClassVar[tuple[str, ...]] = ()

    @property
    def joints(self) -> tuple[str, ...]:
        return tuple(joint.name for joint in self.joint_models)

    @property
    def waits_for_command(self) -> bool:
        """True for raw effort: without a command, effort 0 would drop the arm."""
        return self.interface is Interface.EFFORT and not self.gains

    def start(
        self, indices: Sequence[int], state: JointState
    ) -> ForwardCommandController:
        return ForwardCommandController(self, indices, state)


@final
class ForwardCommandController:
    """Pass commands on to the joints, or follow them with a PID per joint.

    ROS starts effort controllers with a command of 0, which drops the arm.  Here the
    brakes hold until the first command; from then on the effort is the command.

    A PID takes the rate from the last two errors.  The error of a continuous joint goes
    the shortest way round.  That of a revolute joint is the plain difference: the
    shortest way could leave its limits.
    """

    def __init__(
        self, spec: ForwardCommandSpec, indices: Sequence[int], state: JointState
    ) -> None:
        self.spec = spec
        self._is_position = spec.quantity is Interface.POSITION
        self._select = joint_selector(indices)
        self._held = HeldPositions(spec.joint_models, self._select)
        self._state = state
        self.pid = Pid(spec.gains) if spec.gains else None
        self._last_errors = [0.0] * len(indices)  # before the first, as in ROS
        start = [0.0] * len(indices)
        if self._is_position:
            start = list(self._select(state.position))
        self._command = self._within_limits(start)

    def update(self, state: JointState, period: float) -> Sequence[float]:
        """Return the commands, or the output of the PIDs that follow them."""
        self._state = state
        if self.pid is None:
            return self._command
        if not period > 0.0:
            return [0.0] * len(self._command)
        measured = self._select(state.position if self._is_position else state.velocity)
        errors = list(map(self._error, self.spec.joint_models, self._command, measured))
        rates = [
            (error - last) / period
            for error, last in zip(errors, self._last_errors, strict=True)
        ]
        self._last_errors[:] = errors
        return self.pid.update(errors, rates, period)

    def law(self) -> CommandLaw:
        joints = self.spec.joint_models
        wraps = self._is_position
        return CommandLaw(
            self._command,
            self.pid,
            not self._is_position,
            [
                k
                for k, j in enumerate(joints)
                if wraps and j.type is JointType.CONTINUOUS
            ],
            self._last_errors,
        )

    def observe(self, state: JointState) -> None:
        self._state = state

    def _error(self, joint: Joint, desired: float, measured: float) -> float:
        if self._is_position and joint.type is JointType.CONTINUOUS:
            return shortest_turn(measured, desired)
        return desired - measured

    def _within_limits(self, command: list[float]) -> list[float]:
        """Return the allowed positions nearest to ``command``, if a PID follows them.

        Other commands are passed on as they are.
        """
        if self.pid is None or not self._is_position:
            return command
        return [
            value if joint.type is JointType.CONTINUOUS else joint.limits.clamp(value)
            for joint, value in zip(self.spec.joint_models, command, strict=True)
        ]

    def command_joints(self, values: Sequence[float] | float) -> None:
        """Set one command per joint, in the order of the controller's joints.

        Raises:
            ControlError: If the count is wrong or a number is not finite; the last
                command stays.
        """
        spec = self.spec
        joints = spec.joints
        given = checked_commands(
            values,
            len(joints),
            wrong_size=lambda size: (
                f"Dimension of command ({size}) does not match number of joints "
                f"({len(joints)}) of '{spec.name}': {', '.join(joints)}. Not executing!"
            ),
            not_finite=lambda k, value: (
                f"command {value} for joint '{joints[k]}' of '{spec.name}'; "
                "it must be a finite number"
            ),
        )
        self._command = self._within_limits(given)
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
    )
