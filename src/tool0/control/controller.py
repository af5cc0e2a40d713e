"""Protocols of ROS 1 and ROS 2 controllers, as used by the tick and by requests."""

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
    """A running controller.

    A controller is ready for use when it is constructed, and it is discarded when it is
    stopped.
    """

    @property
    def pid(self) -> Pid | None:
        """The PID from errors to commands; None if commands are forwarded."""

    def update(self, state: JointState, period: float) -> Sequence[float]:
        """Return one command per claimed joint, in the order of ``spec.joints``.

        Args:
            state: State of all joints, in the order of the engine.
            period: Time since the last update [s].
        """

    def law(self) -> Law | None:
        """Return the law that replaces ``update`` until an event, or None."""

    def observe(self, state: JointState) -> None:
        """Store the state after the last tick, which the law executed."""

    def setpoint(self) -> Setpoint | None:
        """Return the setpoints of the joints; None if positions are not commanded.

        ``setpoint`` is called between ticks, about a hundred times per second.  For
        efficiency, the result contains only references to immutable values.
        """

    def stop(self) -> None:
        """End the current motion and its goal when the controller is deactivated."""


class ControllerSpec(Protocol):
    """The checked parameters of a controller that is ready to be started."""

    @property
    def name(self) -> str: ...

    @property
    def type(self) -> str:
        """The type, such as ``effort_controllers/JointTrajectoryController``."""

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that the controller claims, in the order of its commands."""

    @property
    def interface(self) -> Interface | None:
        """Command interface to claim for each joint; None for read-only controllers."""

    @property
    def further_interfaces(self) -> tuple[str, ...]:
        """Additional command interfaces to claim, such as ``gpio/io_async``."""

    @property
    def state_interfaces(self) -> tuple[str, ...]:
        """The required state interfaces, such as ``elbow_joint/position``."""

    @property
    def gains(self) -> tuple[Gains, ...]:
        """The gains of each joint; empty if there is no PID."""

    @property
    def waits_for_command(self) -> bool:
        """Whether the brakes stay engaged between the start and the first command."""

    def start(self, indices: Sequence[int], state: JointState) -> Controller:
        """Return a running controller that holds the measured ``state``.

        Args:
            indices: Indices of the controller's joints in the lists of the state.
            state: Measured state at the time of the start.
        """


class TrajectorySpec(ControllerSpec, Protocol):
    """The parameters of a controller that follows trajectories."""

    @property
    def joint_models(self) -> tuple[Joint, ...]:
        """The joints of the controller, with their limits."""

    @property
    def allow_partial_joints_goal(self) -> bool:
        """Whether a goal may specify only some of the controller's joints."""


@runtime_checkable
class TrajectoryFollower(Controller, Protocol):
    """A running controller that follows trajectories.

    Requests are handled between ticks; the argument ``now`` of a request is the
    simulated time of the next tick [s].
    """

    @property
    def spec(self) -> TrajectorySpec: ...

    def follow(self, goal: TrajectoryGoal | MotionPlan, now: float) -> Goal:
        """Replace the motion with ``goal`` and return its handle, or reject the goal.

        A plan starts with the desired motion at ``now``.

        Raises:
            GoalRejectedError: If the goal is rejected; the previous motion continues.
        """

    def command(self, goal: TrajectoryGoal | MotionPlan, now: float) -> None:
        """Follow or reject a goal from a topic, for which no result is reported."""

    def cancel(self, goal: Goal, now: float) -> None:
        """Stop if ``goal`` is the active goal, and end it with the status PREEMPTED."""

    def stop_motion(self, now: float) -> None:
        """Stop the joints, and end the active goal with the status PREEMPTED."""

    def query_state(self, time: float) -> JointsMotion:
        """Return the desired motion at ``time`` [s]; raise ControlError if unknown."""

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
        """Continue with the joint motions that the kernel started.

        ``splines`` contains the motions by joint index.

        ``is_first`` specifies whether the next tick is the first tick of the motions.
        ``has_points`` specifies whether the motions have several points, for
        controllers that treat such motions differently.
        """


@runtime_checkable
class SpeedScalable(Controller, Protocol):
    """A running controller with trajectories that can be slowed down."""

    def scale_speed(self, factor: float) -> None:
        """Set the ratio of trajectory time to simulated time.

        Raises:
            ControlError: If the speed cannot be scaled.
        """


@runtime_checkable
class GripperDriver(Controller, Protocol):
    """A running controller that moves one joint and squeezes objects."""

    @property
    def joint(self) -> Joint: ...

    def drive(
        self,
        position: float,
        max_effort: float | None,
        now: float,
        drive_limits: DriveLimits | None = None,
    ) -> Goal:
        """Start a new goal and return its handle, or reject the goal.

        If ``max_effort`` [N·m | N] is None or 0, the value of the controller applies.
        ``drive_limits`` apply during the goal.

        Raises:
            GoalRejectedError: If the goal is rejected; the previous command stays in
                effect.
        """

    def limits(
        self, max_effort: float | None, max_velocity: float | None
    ) -> DriveLimits | None:
        """Return the limits of the drive for the settings of a goal.

        The result is None if the drive is not limited.  If a setting is None, the value
        of the controller applies.
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
        """Continue with a goal that the kernel started at ``now`` [s].

        The kernel may also have completed the goal.
        """

    def cancel(self, goal: Goal, now: float) -> None:
        """Stop if ``goal`` is the active goal, and end it with the status PREEMPTED."""


@runtime_checkable
class CommandTaker(Controller, Protocol):
    """A running controller that is commanded with one number per joint."""

    def command_joints(self, values: Sequence[float] | float) -> None:
        """Set one command per joint, in the spec's order, or raise ControlError."""

    def stop_motion(self) -> None:
        """Stop the joints unless efforts are commanded."""


@runtime_checkable
class Adjustable(Controller, Protocol):
    """A running controller with parameters that can change."""

    def adjust(self, spec: Any) -> None:
        """Use other parameters of the same class."""  # hence Any; the PID has gains
