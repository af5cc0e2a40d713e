"""Protocols of the controllers of ROS 1 and ROS 2, for the tick and for requests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, runtime_checkable

from tool0.control.law import Law
from tool0.control.parameters import Pid
from tool0.control.spline import JointSpline, MotionPlan
from tool0.control.trajectory import Setpoint, TrajectoryGoal
from tool0.description.drive_limits import DriveLimits
from tool0.description.model import Interface, Joint
from tool0.hardware.engine import JointState
from tool0.protocol.controllers import Gains
from tool0.protocol.goals import Goal
from tool0.protocol.trajectories import JointsMotion


class Controller(Protocol):
    """A running controller, which is ready once it exists; stopping drops it."""

    @property
    def pid(self) -> Pid | None:
        """The PID from errors to commands; None if commands are passed on."""

    def update(self, state: JointState, period: float) -> Sequence[float]:
        """Return one command per claimed joint, in the order of the spec's joints.

        Args:
            state: State of all joints, in the engine's order.
            period: Time since the last update [s].
        """

    def law(self) -> Law | None:
        """Return the law that replaces ``update`` until an event, if there is one."""

    def observe(self, state: JointState) -> None:
        """Store the state of the last tick, which the law executed."""

    def setpoint(self) -> Setpoint | None:
        """Return the joints' setpoints; None if positions are not commanded.

        This is called between ticks, about a hundred times a second, so the result only
        holds references to immutable values.
        """

    def stop(self) -> None:
        """End the current motion and its goal, since the controller is deactivated."""


class ControllerSpec(Protocol):
    """The checked parameters of a controller, ready to be started."""

    @property
    def name(self) -> str: ...

    @property
    def type(self) -> str:
        """The type in YAML, e.g. ``effort_controllers/JointTrajectoryController``."""

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that it claims, in the order of its commands."""

    @property
    def interface(self) -> Interface | None:
        """The command interface of each joint that it claims; None if it only reads."""

    @property
    def further_interfaces(self) -> tuple[str, ...]:
        """Additional command interfaces that it claims, such as ``gpio/io_async``."""

    @property
    def state_interfaces(self) -> tuple[str, ...]:
        """The state interfaces that it requires, such as ``elbow_joint/position``."""

    @property
    def gains(self) -> tuple[Gains, ...]:
        """The gains of each joint; empty without a PID."""

    @property
    def waits_for_command(self) -> bool:
        """Whether the brakes stay on between its start and its first command."""

    def start(self, indices: Sequence[int], state: JointState) -> Controller:
        """Return a running controller that holds the measured ``state``.

        Args:
            indices: Indices of its joints in the state's lists.
            state: Measured state at the time of the start.
        """


class TrajectorySpec(ControllerSpec, Protocol):
    """The parameters of a controller that follows trajectories."""

    @property
    def joint_models(self) -> tuple[Joint, ...]:
        """The joints with their limits."""

    @property
    def allow_partial_joints_goal(self) -> bool:
        """Whether a goal may name only some of its joints."""


@runtime_checkable
class TrajectoryFollower(Controller, Protocol):
    """A running controller that follows trajectories.

    Requests are handled between ticks; their ``now`` is the simulated time of the next
    tick [s].
    """

    @property
    def spec(self) -> TrajectorySpec: ...

    def follow(self, goal: TrajectoryGoal | MotionPlan, now: float) -> Goal:
        """Replace the motion by ``goal`` and return its handle, or reject it.

        A plan starts with the desired motion at ``now``.

        Raises:
            GoalRejectedError: The previous motion then continues.
        """

    def command(self, goal: TrajectoryGoal | MotionPlan, now: float) -> None:
        """Replace the motion without a result, like ROS's topic, or reject it."""

    def cancel(self, goal: Goal, now: float) -> None:
        """Stop if ``goal`` is the active one, which then ends PREEMPTED."""

    def query_state(self, time: float) -> JointsMotion:
        """Return the desired motion at ``time`` [s]; ControlError if unknown."""

    def setpoint(self) -> Setpoint:
        """Return the setpoints of the joints."""

    def resume_from_kernel(
        self,
        splines: Mapping[int, JointSpline],
        now: float,
        *,
        is_first: bool,
        has_points: bool,
    ) -> None:
        """Continue with the motions of joints, by index, that the kernel started.

        ``is_first`` says whether the next tick is the first one of these motions, and
        ``has_points`` whether they have several points, in case the controller
        distinguishes this.
        """


@runtime_checkable
class SpeedScalable(Controller, Protocol):
    """A running controller whose trajectories can be slowed down."""

    def scale_speed(self, factor: float) -> None:
        """Set the ratio of trajectory time to simulated time, or raise ControlError."""


@runtime_checkable
class GripperDriver(Controller, Protocol):
    """A running controller that moves one joint and squeezes whatever stops it."""

    @property
    def joint(self) -> Joint: ...

    def drive(
        self,
        position: float,
        max_effort: float | None,
        now: float,
        drive_limits: DriveLimits | None = None,
    ) -> Goal:
        """Replace the goal and return the new one's handle, or reject it.

        If ``max_effort`` [N·m | N] is None or 0, the controller's own value applies.
        ``drive_limits`` apply during the goal.

        Raises:
            GoalRejectedError: The previous command then continues.
        """

    def limits(
        self, max_effort: float | None, max_velocity: float | None
    ) -> DriveLimits | None:
        """Return the drive's limits with these settings of a goal.

        The result is None if the drive is not limited.  Settings that are None default
        to the controller's own.
        """

    def resume_from_kernel(
        self,
        target: float,
        max_effort: float,
        drive_limits: DriveLimits | None,
        now: float,
        *,
        has_goal: bool,
    ) -> None:
        """Continue with a goal that the kernel started at ``now`` [s] or has ended."""

    def cancel(self, goal: Goal, now: float) -> None:
        """Stop if ``goal`` is the active one, which then ends PREEMPTED."""


@runtime_checkable
class CommandTaker(Controller, Protocol):
    """A running controller that takes one number per joint as its command."""

    def command_joints(self, values: Sequence[float] | float) -> None:
        """Set one command per joint, in the spec's order, or raise ControlError."""


@runtime_checkable
class Adjustable(Controller, Protocol):
    """A running controller whose parameters can change."""

    def adjust(self, spec: Any) -> None:
        """Continue with ``spec``, of the same class."""  # so Any; gains are the pid's
