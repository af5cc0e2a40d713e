"""Controllers that take one number per joint: forwarded, or followed by a PID."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from tool0.control.intent import PositionIntent
from tool0.control.joint_servo import JointServo, Quantity
from tool0.control.parameters import (
    INTERFACE_OF_PACKAGE,
    RobotJoints,
    controlled_joints,
    read_gains,
    single_joint,
)
from tool0.control.pid import Gains
from tool0.description.model import Interface, Joint
from tool0.description.yaml_values import Namespace
from tool0.errors import ControlError
from tool0.hardware.joint_state import JointState
from tool0.hardware.pick import picker


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ForwardCommandSpec:
    """A ``Joint…Controller`` or ``JointGroup…Controller``."""

    name: str
    type: str
    joint_models: tuple[Joint, ...]
    interface: Interface
    quantity: Quantity
    """What its commands are."""
    gains: tuple[Gains, ...] = ()
    """One per joint if the quantity is not the interface's own."""

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints it claims."""
        return tuple(joint.name for joint in self.joint_models)

    @property
    def waits_for_command(self) -> bool:
        """True for raw effort, whose first command, 0, would drop the arm."""
        return self.interface is Interface.EFFORT and not self.gains

    def start(
        self, indices: Sequence[int], state: JointState
    ) -> ForwardCommandController:
        """Return a controller that commands the measured positions, or 0."""
        return ForwardCommandController(self, indices, state)


@final
class ForwardCommandController:
    """Pass commands on to the joints, or follow them with a PID per joint.

    ROS starts effort controllers with a command of 0, which drops the arm.  Here the
    brakes hold until the first command comes; from then on effort is what was said.
    """

    def __init__(
        self, spec: ForwardCommandSpec, indices: Sequence[int], state: JointState
    ) -> None:
        self.spec = spec
        self._command: Sequence[float] = [0.0] * len(indices)
        self._was_commanded = False
        self._pick = picker(indices)
        self._state = state
        self._servo: JointServo | None = None
        if spec.gains:
            self._servo = JointServo(
                spec.quantity, spec.joint_models, spec.gains, indices
            )
        if spec.quantity is Quantity.POSITION:
            self._command = list(self._pick(state.position))
            if self._servo is not None:
                self._command = self._servo.within_limits(self._command)

    def update(self, state: JointState, period: float) -> Sequence[float]:
        """Return the commands, or what the PIDs make of them."""
        self._state = state
        if self._servo is None:
            return self._command
        return self._servo.update(self._command, state, period)

    def command(self, values: Sequence[float] | float) -> None:
        """Set one command per joint, in the order of the controller's joints.

        Raises:
            ControlError: If the count is wrong or a number is not finite; the last
                command stays.
        """
        given = [values] if isinstance(values, int | float) else list(values)
        joints = self.spec.joints
        if len(given) != len(joints):
            raise ControlError(
                f"Dimension of command ({len(given)}) does not match number of joints "
                f"({len(joints)}) of '{self.spec.name}': {', '.join(joints)}. "
                "Not executing!"
            )
        for joint, value in zip(joints, given, strict=True):
            if not math.isfinite(value):
                raise ControlError(
                    f"command {value} for joint '{joint}' of '{self.spec.name}'; "
                    "it must be a finite number"
                )
        self._was_commanded = True
        command = [float(value) for value in given]
        self._command = (
            command if self._servo is None else self._servo.within_limits(command)
        )

    def intent(self) -> PositionIntent | None:
        """Return the positions that were commanded, if positions were."""
        if self.spec.quantity is not Quantity.POSITION or not self._was_commanded:
            return None
        return PositionIntent(
            self.spec.joint_models, tuple(self._command), self._pick, self._state
        )

    def stop(self) -> None:
        """Do nothing: there is no goal to end."""


def parse(parameters: Namespace, robot: RobotJoints) -> ForwardCommandSpec:
    """Return the checked parameters of a forwarding controller."""
    type_name = parameters.text("type")
    package, _, kind = type_name.partition("/")
    interface = INTERFACE_OF_PACKAGE[package]
    is_group = kind.startswith("JointGroup")
    quantity = Quantity[kind[10 if is_group else 5 : -len("Controller")].upper()]
    if is_group:
        joints = controlled_joints(robot, parameters, interface)
    else:
        joints = (single_joint(robot, parameters, interface),)
    gains: tuple[Gains, ...] = ()
    if quantity.name != interface.name:
        paths = [f"{joint.name}/pid" for joint in joints] if is_group else ["pid"]
        why = f"{type_name} needs"
        gains = tuple(read_gains(parameters, path, why) for path in paths)
    return ForwardCommandSpec(
        name=parameters.name,
        type=type_name,
        joint_models=joints,
        interface=interface,
        quantity=quantity,
        gains=gains,
    )
