"""Handles for a controller, and for a goal that the controller has accepted."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from numbers import Real
from typing import TYPE_CHECKING, final

from tool0.errors import GoalTimeoutError, RequestError
from tool0.protocol.channel import Channel
from tool0.protocol.controllers import (
    Gains,
    QueryState,
    ReadController,
    ReadGains,
    SetGains,
)
from tool0.protocol.goals import (
    CancelGoal,
    GoalStarted,
    GoalStatus,
    Result,
    Tolerance,
    ToleranceOverride,
)
from tool0.protocol.motion import CommandGripper, CommandJoints, MoveJoints, SteerJoints
from tool0.protocol.request import CollisionRule, checked_value
from tool0.protocol.trajectories import (
    CommandTrajectory,
    FollowTrajectory,
    JointsMotion,
    Points,
    ScaleTrajectory,
    Tolerances,
    TrajectoryPoint,
    TrajectoryState,
)

if TYPE_CHECKING:
    from tool0.control.controller import ControllerSpec


@final
class GoalHandle:
    """Handle for an accepted goal of a controller, to wait for it or cancel it."""

    def __init__(self, started: GoalStarted, channel: Channel) -> None:
        self._number = started.goal
        self._goal = channel.goal(started)
        self._channel = channel

    @property
    def controller(self) -> str:
        """The name of the controller."""
        return self._goal.controller

    @property
    def status(self) -> GoalStatus:
        """Status of the goal: ACTIVE, or its final status."""
        return self._goal.status

    @property
    def result(self) -> Result | None:
        """The outcome of the goal; None while it is active."""
        return self._goal.result

    def wait(self, timeout: float | None = None) -> Result:
        """Wait until the goal ends, and return its outcome.

        Args:
            timeout: Longest wait [s]; None for no limit.  The timeout is in wall time
                if the simulation runs in real time or in another process.  Otherwise,
                the timeout is in simulated time, and the wait advances this time.

        Raises:
            GoalTimeoutError: If the goal is still active after ``timeout``.
        """
        if self._goal.result is None:
            self._channel.wait_for_goal(self._goal, checked_timeout(timeout))
        if self._goal.result is None:
            raise GoalTimeoutError(
                f"the goal of '{self.controller}' is still active after {timeout} s"
            )
        return self._goal.result

    def cancel(self) -> None:
        """Cancel the goal: the controller decelerates to rest.

        The goal ends as PREEMPTED.

        A goal that has already ended is not changed.
        """
        if self._goal.result is None:
            self._channel.call(CancelGoal(goal=self._number))

    def when_finished(self, callback: Callable[[GoalHandle], None]) -> None:
        """Call ``callback(handle)`` when the goal ends, or now if it has already ended.

        A thread of the simulation executes the callback, and waits until it returns.
        Therefore, the callback must be short.
        """
        if not callable(callback):
            raise RequestError("when_finished", f"cannot call {callback!r:.80}")
        self._goal.when_finished(lambda _: callback(self))

    def __repr__(self) -> str:
        return f"GoalHandle({self.controller!r}, {self.status!r})"


@final
class ControllerHandle:
    """Handle for a loaded controller; the supported methods depend on its type."""

    def __init__(self, name: str, channel: Channel) -> None:
        self._name = name
        self._channel = channel

    @property
    def name(self) -> str:
        """Name of the controller in the YAML."""
        return self._name

    def follow(
        self,
        points: Sequence[TrajectoryPoint],
        *,
        joint_names: Sequence[str] | None = None,
        stamp: float | None = None,
        path_tolerance: Mapping[str, ToleranceOverride] | None = None,
        goal_tolerance: Mapping[str, ToleranceOverride] | None = None,
        goal_time_tolerance: float | None = None,
    ) -> GoalHandle:
        """Send a trajectory as a goal; a trajectory without points stops the motion.

        Args:
            points: Setpoints and their times; values are in the order of
                ``joint_names``.
            joint_names: Joints of the points; the default is the controller's joints.
            stamp: Simulated time at which the trajectory starts [s]; by default, it
                starts immediately.
            path_tolerance: Joint → maximum error during the motion [rad | m]; a
                negative value disables the check.
            goal_tolerance: Joint → maximum error at the end [rad | m]; a negative value
                disables the check.
            goal_time_tolerance: Time after the last point within which the goal must be
                reached [s]; a negative value disables the check.

        Raises:
            GoalRejectedError: If the controller refuses the trajectory; the present
                motion then continues.
        """
        request = FollowTrajectory(
            controller=self.name,
            points=_points("follow", points),
            joint_names=joint_names,  # type: ignore[arg-type]  # any: it is checked
            stamp=stamp,
            path_tolerance=_by_joint("path_tolerance", path_tolerance),
            goal_tolerance=_by_joint("goal_tolerance", goal_tolerance),
            goal_time_tolerance=goal_time_tolerance,
        )
        return GoalHandle(self._channel.call(request), self._channel)

    def command_trajectory(
        self,
        points: Sequence[TrajectoryPoint],
        *,
        joint_names: Sequence[str] | None = None,
        stamp: float | None = None,
    ) -> None:
        """Send a trajectory without a goal, as on the ROS topic ``command``.

        There is no result, and tolerances are not checked.  With controllers of ROS 2,
        a violated tolerance stops the motion, and an active goal continues with the new
        points.

        Args:
            points: Setpoints and their times; values are in the order of
                ``joint_names``.  An empty sequence stops the motion.
            joint_names: Joints of the points; the default is the controller's joints.
            stamp: Simulated time at which the trajectory starts [s]; by default, it
                starts immediately.

        Raises:
            GoalRejectedError: If the controller refuses the trajectory; the present
                motion then continues.
        """
        request = CommandTrajectory(
            controller=self.name,
            points=_points("command_trajectory", points),
            joint_names=joint_names,  # type: ignore[arg-type]
            stamp=stamp,
        )
        self._channel.call(request)

    def scale_speed(self, factor: float) -> None:
        """Scale the speed of trajectories, as ``speed_scaling_input`` does in ROS 2.

        ``factor`` is the ratio of trajectory time to simulated time: 1 is the original
        speed, and 0 pauses the trajectory.

        Raises:
            ControlError: If this controller is not a ROS 2 trajectory controller that
                commands positions, or if the arm's speed slider scales its speed.
        """
        self._channel.call(ScaleTrajectory(controller=self.name, factor=factor))

    def move(
        self,
        positions: Mapping[str, float],
        *,
        speed: float = 0.5,
        duration: float | None = None,
        collision: CollisionRule = "refuse",
    ) -> GoalHandle:
        """Move joints of a trajectory controller smoothly.

        The motion starts at the current setpoints, obeys the limits of the joints, and
        ends at rest.  The other joints continue their motion.

        Args:
            positions: Joint → target [rad | m].
            speed: Fraction of each joint's maximum velocity, 0.01 … 1.
            duration: Duration of the motion [simulated s], instead of a speed.
            collision: See ``Robot.move_joints``.

        Raises:
            CollisionError: If an arm would collide.
            GoalRejectedError: If the controller does not have a joint, or if a position
                is outside the joint's limits; the present motion then continues.
        """
        request = MoveJoints(
            positions=positions,  # type: ignore[arg-type]
            speed=speed,
            duration=duration,
            controller=self.name,
            collision=collision,
        )
        (started,) = self._channel.call(request)
        return GoalHandle(started, self._channel)

    def steer(self, positions: Mapping[str, float], *, speed: float = 0.5) -> None:
        """Move joints as ``move`` does, but without a goal.

        Use this method for streams of setpoints, for example ten setpoints per second.
        Position, velocity and acceleration are continuous.

        Args:
            positions: Joint → target [rad | m].
            speed: Fraction of each joint's maximum velocity, 0.01 … 1.

        Raises:
            GoalRejectedError: See ``move``.
        """
        self._channel.call(
            SteerJoints(
                controller=self.name,
                positions=positions,  # type: ignore[arg-type]
                speed=speed,
            )
        )

    def command_gripper(
        self,
        position: float,
        max_effort: float | None = None,
        *,
        max_velocity: float | None = None,
    ) -> GoalHandle:
        """Send a goal to a GripperActionController, as an action client in ROS does.

        Args:
            position: Position of the driven joint [rad | m].
            max_effort: Maximum effort of the drive [N·m | N].  If the value is left out
                or 0, the default of the controller is used.  ROS 2's parallel gripper
                controller writes the value to its ``max_effort_interface``, where the
                value is the force of the pads [N].
            max_velocity: Maximum speed of the pads [m/s].  Without a value, the default
                of the controller applies.  ROS 2's parallel gripper controller writes
                the value to its ``max_velocity_interface``.

        Raises:
            GoalRejectedError: If the position is outside the joint's limits.
            ControlError: If the controller is of another type.
        """
        request = CommandGripper(
            controller=self.name,
            position=position,
            max_effort=max_effort,
            max_velocity=max_velocity,
        )
        return GoalHandle(self._channel.call(request), self._channel)

    def command(self, values: float | Sequence[float]) -> None:
        """Send setpoints to a controller such as JointGroupEffortController.

        Args:
            values: One setpoint per joint, in the order of the controller's joints.
                The type of the controller determines the unit: [rad | m], [rad/s | m/s]
                or [N·m | N].

        Raises:
            ControlError: If the number of values is wrong, or if a value is not finite.
        """
        given = (values,) if isinstance(values, Real) else values
        self._channel.call(
            CommandJoints(
                controller=self.name,
                values=given,  # type: ignore[arg-type]
            )
        )

    def query_state(self, time: float | None = None) -> JointsMotion:
        """Return the setpoint of a trajectory controller.

        Args:
            time: Simulated time of the setpoint [s]; the default is the present time.

        Raises:
            ControlError: If the trajectory at this time is no longer stored.
        """
        return self._channel.call(QueryState(controller=self.name, time=time))

    @property
    def state(self) -> TrajectoryState:
        """Desired motion, measured motion and error of a trajectory controller."""
        return self._channel.call(ReadController(controller=self.name))

    @property
    def gains(self) -> Mapping[str, Gains]:
        """Current PID gains by joint; empty if the controller has no PID."""
        return self._channel.call(ReadGains(controller=self.name))

    def set_gains(
        self,
        joint: str,
        *,
        p: float | None = None,
        i: float | None = None,
        d: float | None = None,
        i_clamp: float | None = None,
        antiwindup: bool | None = None,
    ) -> Gains:
        """Change the PID gains of a joint, and return all its gains.

        Omitted gains keep their values.  The gains can be changed during a motion.  The
        integral term does not jump unless the new clamp limits the term.  The gains
        apply until the controller is unloaded, even after resets and restarts; they are
        not written to a file.

        Args:
            joint: A joint of the controller.
            p: Proportional gain; [N·m/rad | N/m] for an effort controller.
            i: Integral gain; [N·m/(rad·s) | N/(m·s)] for an effort controller.
            d: Derivative gain; [N·m·s/rad | N·s/m] for an effort controller.
            i_clamp: Maximum magnitude of the integral term, 0 or more; [N·m | N] for an
                effort controller.
            antiwindup: Whether the integral itself is clamped, in addition to the
                integral term.

        Raises:
            ControlError: If the controller has no gains, if it does not have the joint,
                or if a value is out of range; all gains are then unchanged.
        """
        request = SetGains(
            controller=self.name,
            joint=joint,
            p=p,
            i=i,
            d=d,
            i_clamp=i_clamp,
            antiwindup=antiwindup,
        )
        return self._channel.call(request)

    @property
    def spec(self) -> ControllerSpec:
        """Parameters of the loaded controller, including later changes to its gains.

        Raises:
            ControlError: If the simulation runs in another process.
        """
        from tool0.simulation.handlers.motion import ReadControllerSpec

        return self._channel.call(ReadControllerSpec(controller=self.name))

    def __repr__(self) -> str:
        return f"ControllerHandle({self.name!r})"


def _points(method: str, points: Sequence[TrajectoryPoint]) -> Points:
    """Return the points of a trajectory, or raise RequestError if they are invalid."""
    try:
        given = tuple(points)
    except TypeError:
        wrong: object = points
    else:
        others = [point for point in given if not isinstance(point, TrajectoryPoint)]
        if not others:
            return given
        wrong = others[0]
    raise RequestError(method, f"'points': need TrajectoryPoints, got {wrong!r:.80}")


def _by_joint(
    name: str, tolerances: Mapping[str, ToleranceOverride] | None
) -> Tolerances:
    """Return tolerances in request form, or raise RequestError if they are invalid.

    The controller rejects the goal if a tolerance is not finite.
    """
    if tolerances is None:
        return {}
    try:
        return {
            str.__str__(joint): Tolerance(*map(_number, value))
            if isinstance(value, Tolerance)
            else _number(value)
            for joint, value in tolerances.items()
        }
    except (AttributeError, TypeError, OverflowError):
        problem = f"'{name}': need numbers by joint, got {tolerances!r:.80}"
        raise RequestError("follow", problem) from None


def _number(value: object) -> float:
    """Return a number as a Python float; raise TypeError for another value."""
    if not isinstance(value, Real):
        raise TypeError(value)
    return float(value)


def checked_timeout(timeout: float | None) -> float | None:
    """Return a timeout [s] (None: no limit), or raise RequestError if it is invalid."""
    if timeout is None or timeout is math.inf:
        return None
    seconds: float = checked_value("wait", "timeout", timeout, float)
    return seconds
