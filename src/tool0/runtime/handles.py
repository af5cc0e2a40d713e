"""Handles that a person holds: a goal that was accepted, a controller by its name."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import final

from tool0.control.controller import ControllerSpec
from tool0.control.goal import Goal, GoalStatus, Result
from tool0.control.tolerances import ToleranceOverride
from tool0.control.trajectory import TrajectoryGoal, TrajectoryPoint, TrajectoryState
from tool0.errors import GoalTimeoutError
from tool0.hardware.drive_limits import DriveLimits
from tool0.runtime import commands as ask
from tool0.runtime.joint_motion import import_planner
from tool0.runtime.loop import Loop


@final
class GoalHandle:
    """A goal that was accepted: wait for it, or cancel it."""

    def __init__(self, goal: Goal, loop: Loop) -> None:
        self._goal = goal
        self._loop = loop

    @property
    def controller(self) -> str:
        return self._goal.controller

    @property
    def status(self) -> GoalStatus:
        return self._goal.status

    @property
    def result(self) -> Result | None:
        """How it ended; None while it is active."""
        return self._goal.result

    def wait(self, timeout: float | None = None) -> Result:
        """Wait until the goal ends and return how.

        Args:
            timeout: Longest wait [s]: of wall time if the simulation runs in real
                time, else of simulated time, which passes meanwhile.

        Raises:
            GoalTimeoutError: If the goal is still active then.
        """
        if self._goal.result is not None:
            return self._goal.result
        if self._loop.is_realtime:
            self._loop.wait_for(self._goal, timeout)
        else:
            self._loop.run(
                float("inf") if timeout is None else timeout,
                until=lambda: self._goal.status.is_terminal,
            )
        if self._goal.result is None:
            raise GoalTimeoutError(
                f"the goal of '{self.controller}' is still active after {timeout} s"
            )
        return self._goal.result

    def cancel(self) -> None:
        """Stop as ROS does: ramp down, and the goal is PREEMPTED."""
        self._loop.call(ask.CancelGoal(self._goal))

    def when_finished(self, callback: Callable[[GoalHandle], None]) -> None:
        """Call ``callback(handle)`` when the goal ends, or now if it has ended.

        It runs in the thread of the tick, which waits for it: hand work on.
        """
        self._goal.when_finished(lambda _: callback(self))

    def __repr__(self) -> str:
        return f"GoalHandle({self.controller!r}, {self.status!r})"


@final
class ControllerHandle:
    """A loaded controller, by name; what it can do depends on its type."""

    def __init__(self, name: str, loop: Loop) -> None:
        self.name = name
        self._loop = loop

    def follow(
        self,
        points: Sequence[TrajectoryPoint],
        *,
        joint_names: Sequence[str] | None = None,
        stamp: float | None = None,
        path_tolerance: Mapping[str, ToleranceOverride] | None = None,
        goal_tolerance: Mapping[str, ToleranceOverride] | None = None,
        goal_time_tolerance: float | None = None,
        bounds: Mapping[str, DriveLimits] | None = None,
    ) -> GoalHandle:
        """Send a trajectory as a goal; no points stop the motion.

        Args:
            points: Where to be when, in the order of ``joint_names``.
            joint_names: The joints of the points; the controller's, if left out.
            stamp: Simulated time at which the trajectory starts [s]; now, if left out.
            path_tolerance: Largest error on the way, by joint [rad | m]; below 0
                switches the check off.
            goal_tolerance: Largest error at the end, by joint [rad | m]; likewise.
            goal_time_tolerance: Grace after the last point [s]; likewise.
            bounds: Joint → what bounds its drive until the joint's next goal.

        Raises:
            GoalRejectedError: If the controller refuses; what it does goes on.
        """
        goal = TrajectoryGoal(
            points=tuple(points),
            joint_names=None if joint_names is None else tuple(joint_names),
            stamp=stamp,
            path_tolerance=dict(path_tolerance or {}),
            goal_tolerance=dict(goal_tolerance or {}),
            goal_time_tolerance=goal_time_tolerance,
        )
        command = ask.FollowTrajectory(
            controller=self.name, goal=goal, bounds=dict(bounds or {})
        )
        return GoalHandle(self._loop.call(command), self._loop)

    def command_trajectory(
        self,
        points: Sequence[TrajectoryPoint],
        *,
        joint_names: Sequence[str] | None = None,
        stamp: float | None = None,
    ) -> None:
        """Send a trajectory without an outcome, as the ``command`` topic does."""
        goal = TrajectoryGoal(
            points=tuple(points),
            joint_names=None if joint_names is None else tuple(joint_names),
            stamp=stamp,
        )
        self._loop.call(ask.CommandTrajectory(controller=self.name, goal=goal))

    def move(self, positions: Mapping[str, float], *, speed: float = 0.5) -> GoalHandle:
        """Send joints of a trajectory controller somewhere by a smooth motion.

        It starts as the joints are wanted to move now, keeps to their limits and ends
        at rest; joints that are not named go on to where they are going, or stay.

        Args:
            positions: Joint → where to [rad | m].
            speed: Part of each joint's largest velocity, 0.01 … 1.

        Raises:
            GoalRejectedError: If a joint is not the controller's, or a position is out
                of its limits; what the controller does goes on.
        """
        import_planner()
        command = ask.MoveJoints(
            positions=dict(positions), speed=speed, controller=self.name
        )
        (goal,) = self._loop.call(command)
        return GoalHandle(goal, self._loop)

    def steer(self, positions: Mapping[str, float], *, speed: float = 0.5) -> None:
        """Move joints as ``move`` does, without an outcome.

        Made to be called again and again, ten times a second say, with ever new
        positions: position, velocity and acceleration stay continuous.
        """
        import_planner()
        command = ask.SteerJoints(
            controller=self.name, positions=dict(positions), speed=speed
        )
        self._loop.call(command)

    def command_gripper(
        self,
        position: float,
        max_effort: float | None = None,
        *,
        bounds: DriveLimits | None = None,
    ) -> GoalHandle:
        """Send a gripper goal, in joint units: [rad | m] and [N·m | N].

        ``bounds`` are those of the joint's drive until its next goal.
        """
        command = ask.CommandGripper(
            controller=self.name,
            position=position,
            max_effort=max_effort,
            bounds=bounds,
        )
        return GoalHandle(self._loop.call(command), self._loop)

    def command(self, values: float | Sequence[float]) -> None:
        """Set the set-points of a forwarding controller, in its joints' order."""
        wanted = tuple(values) if isinstance(values, Sequence) else (values,)
        self._loop.call(ask.CommandJoints(controller=self.name, values=wanted))

    def query_state(self, time: float) -> TrajectoryPoint:
        """Return what a trajectory controller wants at simulated ``time`` [s]."""
        point: TrajectoryPoint = self._loop.call(
            ask.QueryState(controller=self.name, time=time)
        )
        return point

    @property
    def state(self) -> TrajectoryState:
        """Desired, actual and error of a trajectory controller."""
        state: TrajectoryState = self._loop.call(ask.ReadController(self.name))
        return state

    @property
    def spec(self) -> ControllerSpec:
        """The parameters that the controller was loaded with."""
        spec: ControllerSpec = self._loop.call(ask.ReadSpec(self.name))
        return spec

    def __repr__(self) -> str:
        return f"ControllerHandle({self.name!r})"
