"""Controllers that forward one number per joint, or follow it with a PID."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Final, NamedTuple, final

from tool0.control.law import CommandLaw
from tool0.control.parameters import Pid
from tool0.control.spline import JointSpline, hold
from tool0.control.trajectory import Setpoint
from tool0.description.model import Interface, Joint, JointType, shortest_turn
from tool0.errors import ControlError
from tool0.hardware.engine import JointState, joint_selector
from tool0.protocol.controllers import Gains

MOVES: Final = 0.01
"""Speed above which a joint counts as moving to its command [rad/s | m/s]."""


class CommandWording(NamedTuple):
    """A dialect's messages for rejected commands, as format strings."""

    wrong_size: str
    """Message for a wrong number of values, with the fields ``size``, ``n_joints``,
    ``joints`` and ``controller``."""
    not_finite: str
    """Message for a number that is not finite, with the fields ``value``, ``joint`` and
    ``controller``."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ForwardCommandSpec:
    """The parameters of a controller that forwards commands or follows them."""

    name: str
    type: str
    joint_models: tuple[Joint, ...]
    interface: Interface
    quantity: Interface
    """The quantity that is commanded.  A PID follows the command unless ``interface``
    accepts the commanded quantity itself."""
    gains: tuple[Gains, ...] = ()
    """Gains of each joint if ``quantity`` differs from ``interface``."""
    wording: CommandWording

    further_interfaces: ClassVar[tuple[str, ...]] = ()
    state_interfaces: ClassVar[tuple[str, ...]] = ()

    @property
    def joints(self) -> tuple[str, ...]:
        return tuple(joint.name for joint in self.joint_models)

    @property
    def waits_for_command(self) -> bool:
        """Whether the controller forwards efforts.

        If efforts are forwarded, an initial effort of 0 would drop the arm.
        """
        return self.interface is Interface.EFFORT and not self.gains

    def start(
        self, indices: Sequence[int], state: JointState
    ) -> ForwardCommandController:
        return ForwardCommandController(self, indices, state)


@final
class ForwardCommandController:
    """Forwards the newest command to the joints, or follows it with a PID per joint.

    ROS 1 starts effort controllers with a command of 0, which drops the arm.
    ForwardCommandController keeps the brakes engaged until the first command, and then
    applies commands as efforts.  Position commands start at the measured positions, and
    velocity commands start at 0.

    A PID computes the error's rate from the last two errors.  The error of a continuous
    joint is wrapped to the shortest rotation.  The error of a revolute joint is the
    plain difference, since the shortest rotation could exceed the joint's limits.
    """

    def __init__(
        self, spec: ForwardCommandSpec, indices: Sequence[int], state: JointState
    ) -> None:
        self.spec = spec
        self._is_position = spec.quantity is Interface.POSITION
        self._select = joint_selector(indices)
        self._state = state
        self.pid = Pid(spec.gains) if spec.gains else None
        self._last_errors = [0.0] * len(indices)  # before the first update, as in ROS
        start = [0.0] * len(indices)
        if self._is_position:
            start = list(self._select(state.position))
        self._command = self._within_limits(start)
        self._is_commanded = False
        self._holds: tuple[JointSpline, ...] = ()
        """The commanded positions as splines; empty until the setpoint is read."""

    def update(self, state: JointState, period: float) -> Sequence[float]:
        """Return the commands, or the outputs of the PIDs that follow the commands."""
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
        joints = enumerate(self.spec.joint_models)
        return CommandLaw(
            self._command,
            self.pid,
            not self._is_position,
            [k for k, joint in joints if self._wraps(joint)],
            self._last_errors,
        )

    def observe(self, state: JointState) -> None:
        self._state = state

    def _wraps(self, joint: Joint) -> bool:
        return self._is_position and joint.type is JointType.CONTINUOUS

    def _error(self, joint: Joint, desired: float, measured: float) -> float:
        if self._wraps(joint):
            return shortest_turn(measured, desired)
        return desired - measured

    def _within_limits(self, command: list[float]) -> list[float]:
        """Return the allowed positions nearest to ``command`` for a position PID.

        Other commands are returned unchanged.
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
            ControlError: If the number of values is wrong or a value is not finite; in
                this case, the last command stays in effect.
        """
        self._command = self._within_limits(self._checked(values))
        self._is_commanded, self._holds = True, ()

    def stop_motion(self) -> None:
        """Command the speed 0, or the measured positions if a joint moves.

        Commanded efforts stay in effect, since an effort holds no joint.
        """
        state, select = self._state, self._select
        if self.spec.quantity is Interface.VELOCITY:
            self.command_joints([0.0] * len(self._command))
        elif self._is_position and max(map(abs, select(state.velocity))) > MOVES:
            self.command_joints(select(state.position))

    def _checked(self, values: Sequence[float] | float) -> list[float]:
        spec = self.spec
        given = [values] if isinstance(values, int | float) else list(values)
        if len(given) != len(spec.joint_models):
            text = spec.wording.wrong_size.format(
                size=len(given),
                n_joints=len(spec.joint_models),
                joints=", ".join(spec.joints),
                controller=spec.name,
            )
            raise ControlError(text)
        for joint, value in zip(spec.joints, given, strict=True):
            if not math.isfinite(value):
                text = spec.wording.not_finite.format(
                    value=value, joint=joint, controller=spec.name
                )
                raise ControlError(text)
        return [float(value) for value in given]

    def setpoint(self) -> Setpoint | None:
        """Return the commanded positions as setpoints, or None without commands."""
        if not (self._is_position and self._is_commanded):
            return None
        time = self._state.time
        if not self._holds:
            self._holds = tuple(hold(time, value) for value in self._command)
        joints = self.spec.joint_models
        return Setpoint(joints, self._holds, self._select, self._state)

    def stop(self) -> None:
        """Do nothing, since there is no goal to end."""
