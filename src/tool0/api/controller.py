"""Handles on a controller, on a goal that it accepted, and on a gripper."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import final

from tool0.api.channel import Channel
from tool0.control.config import ControllerSpec
from tool0.control.goal import GoalStatus, Result, ToleranceOverride
from tool0.control.trajectory import JointsMotion, TrajectoryPoint, TrajectoryState
from tool0.description.model import ParallelGripper
from tool0.errors import GoalTimeoutError
from tool0.requests import motion
from tool0.requests.gripper import Grip, ReadGripper
from tool0.sensing.grasp import GraspState


@final
class GoalHandle:
    """A goal that a controller accepted: wait for it, or cancel it."""

    def __init__(self, started: motion.GoalStarted, channel: Channel) -> None:
        self._number = started.goal
        self._goal = channel.goal(started)
        self._channel = channel

    @property
    def controller(self) -> str:
        return self._goal.controller

    @property
    def status(self) -> GoalStatus:
        return self._goal.status

    @property
    def result(self) -> Result | None:
        """The outcome; None while the goal is active."""
        return self._goal.result

    def wait(self, timeout: float | None = None) -> Result:
        """Wait until the goal ends, and return its outcome.

        Args:
            timeout: Longest wait [s]: of wall time if the simulation runs in real
                time or in another process, otherwise of simulated time, which passes
                meanwhile.

        Raises:
            GoalTimeoutError: If the goal is still active then.
        """
        if self._goal.result is None:
            self._channel.wait_for_goal(self._goal, timeout)
        if self._goal.result is None:
            raise GoalTimeoutError(
                f"the goal of '{self.controller}' is still active after {timeout} s"
            )
        return self._goal.result

    def cancel(self) -> None:
        """Stop as ROS does: ramp down, and the goal is PREEMPTED."""
        if self._goal.result is None:
            self._channel.call(motion.CancelGoal(goal=self._number))

    def when_finished(self, callback: Callable[[GoalHandle], None]) -> None:
        """Call ``callback(handle)`` when the goal ends, or now if it has ended.

        It runs in a thread of the simulation, which waits for it: keep it short.
        """
        self._goal.when_finished(lambda _: callback(self))

    def __repr__(self) -> str:
        return f"GoalHandle({self.controller!r}, {self.status!r})"


@final
class ControllerHandle:
    """A loaded controller, by name; what it can do depends on its type."""

    def __init__(self, name: str, channel: Channel) -> None:
        self.name = name
        self._channel = channel

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
        """Send a trajectory as a goal; no points stop the motion.

        Args:
            points: Setpoints at their times, in the order of ``joint_names``.
            joint_names: The joints of the points; the controller's, if left out.
            stamp: Simulated time at which the trajectory starts [s]; now, if left out.
            path_tolerance: Largest error on the way, by joint [rad | m]; below 0
                disables the check.
            goal_tolerance: Largest error at the end, by joint [rad | m]; likewise.
            goal_time_tolerance: Grace after the last point [s]; likewise.

        Raises:
            GoalRejectedError: If the controller refuses; its motion continues.
        """
        request = motion.FollowTrajectory(
            controller=self.name,
            points=tuple(points),
            joint_names=None if joint_names is None else tuple(joint_names),
            stamp=stamp,
            path_tolerance=dict(path_tolerance or {}),
            goal_tolerance=dict(goal_tolerance or {}),
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
        """Send a trajectory without a goal, as the ``command`` topic does."""
        request = motion.CommandTrajectory(
            controller=self.name,
            points=tuple(points),
            joint_names=None if joint_names is None else tuple(joint_names),
            stamp=stamp,
        )
        self._channel.call(request)

    def move(
        self,
        positions: Mapping[str, float],
        *,
        speed: float = 0.5,
        duration: float | None = None,
    ) -> GoalHandle:
        """Move joints of a trajectory controller smoothly.

        The motion starts from the present setpoints, keeps to the joints' limits and
        ends at rest; joints that are not named continue to where they are going.

        Args:
            positions: Joint → target [rad | m].
            speed: Fraction of each joint's largest velocity, 0.01 … 1.
            duration: Instead of a speed: how long the motion takes [simulated s].

        Raises:
            GoalRejectedError: If a joint is not the controller's, or a position is out
                of its limits; the controller's motion continues.
        """
        request = motion.MoveJoints(
            positions=dict(positions),
            speed=speed,
            duration=duration,
            controller=self.name,
        )
        (started,) = self._channel.call(request)
        return GoalHandle(started, self._channel)

    def steer(self, positions: Mapping[str, float], *, speed: float = 0.5) -> None:
        """Move joints as ``move`` does, without a goal.

        It is made for streams of setpoints, ten times a second for example: position,
        velocity and acceleration stay continuous.
        """
        self._channel.call(
            motion.SteerJoints(
                controller=self.name, positions=dict(positions), speed=speed
            )
        )

    def command_gripper(
        self, position: float, max_effort: float | None = None
    ) -> GoalHandle:
        """Send a gripper goal in joint units: [rad | m] and [N·m | N]."""
        request = motion.CommandGripper(
            controller=self.name, position=position, max_effort=max_effort
        )
        return GoalHandle(self._channel.call(request), self._channel)

    def command(self, values: float | Sequence[float]) -> None:
        """Send the setpoints of a forwarding controller, in its joints' order."""
        given = tuple(values) if isinstance(values, Sequence) else (values,)
        self._channel.call(motion.CommandJoints(controller=self.name, values=given))

    def query_state(self, time: float | None = None) -> JointsMotion:
        """Return the setpoint of a trajectory controller at simulated ``time`` [s].

        The present one, if it is left out.
        """
        return self._channel.call(motion.QueryState(controller=self.name, time=time))

    @property
    def state(self) -> TrajectoryState:
        """Desired, actual and error of a trajectory controller."""
        return self._channel.call(motion.ReadController(controller=self.name))

    @property
    def spec(self) -> ControllerSpec:
        """The parameters it was loaded with; not from another process."""
        return self._channel.call(motion.ReadControllerSpec(controller=self.name))

    def __repr__(self) -> str:
        return f"ControllerHandle({self.name!r})"


@final
class Gripper:
    """Moves one parallel gripper through the controller that claims its joint."""

    def __init__(self, geometry: ParallelGripper, channel: Channel) -> None:
        self.geometry = geometry
        self._channel = channel

    @property
    def name(self) -> str:
        return self.geometry.name

    @property
    def opening(self) -> float:
        """Distance between the pads [m], 0 closed."""
        snapshot = self._channel.snapshot
        index = snapshot.joint_names.index(self.geometry.joint)
        return max(0.0, self.geometry.opening(snapshot.position[index]))

    @property
    def state(self) -> GraspState:
        """Whether it moves, has arrived or holds something, and how wide that is.

        Computed from the last tenth of a second.
        """
        return self._channel.call(ReadGripper(gripper=self.name))

    def wait(self, timeout: float | None = None) -> GraspState:
        """Wait until it no longer moves, and return its state then.

        A change of force alone is no motion: it takes no time here.  ``timeout`` is as
        for ``GoalHandle.wait``.

        Raises:
            GoalTimeoutError: If it still moves then.
        """
        state = self.state

        def stands_still() -> bool:
            nonlocal state
            state = self.state
            return state.motion != "moving"

        if not self._channel.wait_until(stands_still, timeout):
            raise GoalTimeoutError(f"the gripper still moves after {timeout} s")
        return state

    def move(
        self,
        *,
        opening: float | None = None,
        position: float | None = None,
        speed: float | None = None,
        force: float | None = None,
        effort: float | None = None,
    ) -> GoalHandle:
        """Move the pads to ``opening`` and return the goal.

        Speed and force are settings of the drive, as on the real gripper: they hold
        until another goal moves its joint.

        Args:
            opening: Distance between the pads [m], 0 … ``geometry.max_opening``.
            position: Instead of an opening: position of the driven joint [rad].
            speed: Of the pads relative to each other [m/s], within
                ``geometry.speed``; the fastest, if left out.
            force: Largest force at each pad [N], within ``geometry.force``: an object
                in between is gripped with it.  The strongest, if left out.
            effort: Instead of a force: largest torque of the driven joint [N·m], as
                ``max_effort`` of ROS's GripperCommand.

        Raises:
            ModelError: If the opening is out of reach.
            ControlError: If speed, force or effort are out of range, or no running
                controller takes the command; nothing has changed then.
        """
        request = Grip(
            gripper=self.name,
            opening=opening,
            position=position,
            speed=speed,
            force=force,
            effort=effort,
        )
        return GoalHandle(self._channel.call(request), self._channel)
