"""JointTrajectoryController of ROS 2, in which all joints follow one trajectory."""

from __future__ import annotations

import contextlib
import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple

from tool0.control.goal_motion import check_limits, splines_by_plan
from tool0.control.joint_tracking import JointTracking
from tool0.control.law import TrajectoryClock, TrajectoryLaw, TrajectoryStart
from tool0.control.ros2.trajectory_check import (
    Acceptance,
    active_tolerances,
    check_goal,
    override_tolerances,
)
from tool0.control.ros2.trajectory_motion import (
    Course,
    decelerated,
    splines_at_once,
    splines_spliced,
    upsampled,
)
from tool0.control.ros2.trajectory_settings import Replacement, SpeedSource
from tool0.control.sampler import TrajectorySampler
from tool0.control.spline import JointSpline, Motion, MotionPlan, hold
from tool0.control.tolerances import TrajectoryTolerances
from tool0.control.trajectory import Setpoint, TrajectoryGoal, joints_motion
from tool0.control.trajectory_monitor import TrajectoryMonitor
from tool0.description.model import Interface, Joint
from tool0.errors import GoalRejectedError
from tool0.hardware.engine import JointState
from tool0.protocol.controllers import Gains
from tool0.protocol.goals import Goal, GoalResult, GoalStatus
from tool0.protocol.trajectories import JointsMotion

logger = logging.getLogger(__name__)

CANCELED = GoalResult(status=GoalStatus.PREEMPTED)
REPLACED = GoalResult(
    status=GoalStatus.ABORTED,
    error_code=GoalResult.INVALID_GOAL,
    error_string="Current goal preempted by new incoming action.",
)
DEACTIVATED = GoalResult(
    status=GoalStatus.ABORTED,
    error_code=GoalResult.INVALID_GOAL,
    error_string="Current goal cancelled during deactivate transition.",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class JointTrajectorySpec:
    """The parameters of a JointTrajectoryController."""

    name: str
    type: str
    joint_models: tuple[Joint, ...]
    interface: Interface
    further_interfaces: tuple[str, ...] = ()
    state_interfaces: tuple[str, ...] = ()
    gains: tuple[Gains, ...] = ()
    """Gains of each joint; empty if positions are commanded."""
    velocity_ff: tuple[float, ...] = ()
    """Feed-forward factors from desired velocity to command, one per joint; empty if
    positions are commanded."""
    judges_velocity: bool = False
    """Whether velocity tolerances are checked."""
    reads_velocity: bool = True
    """Whether trajectories start with the measured velocity instead of 0."""
    acceptance: Acceptance
    tolerances: TrajectoryTolerances
    deceleration: tuple[float, ...] = ()
    """Deceleration of each joint in a stop [rad/s² | m/s²].  If the tuple is empty, the
    joints hold their measured positions immediately."""
    command_timeout: float = math.inf
    """Time after the end of a trajectory at which the measured position is held [s]."""
    replacement: Replacement
    speed: SpeedSource
    state_publish_rate: float = 50.0
    """Publication rate of the state [Hz]; only ROS 2 Humble has the parameter for this
    rate."""
    action_monitor_rate: float = 20.0
    """Rate of the feedback of the ROS action [Hz]."""

    waits_for_command: ClassVar[bool] = False

    @property
    def joints(self) -> tuple[str, ...]:
        return tuple(joint.name for joint in self.joint_models)

    @property
    def allow_partial_joints_goal(self) -> bool:
        return self.acceptance.allows_partial

    def start(
        self, indices: Sequence[int], state: JointState
    ) -> JointTrajectoryController:
        return JointTrajectoryController(self, indices, state)


class _PendingTrajectory(NamedTuple):
    """A trajectory that replaces all motion in the next tick."""

    course: Course
    held: Mapping[str, float]
    """Positions of the joints that the trajectory does not contain; these joints stay
    at their positions [rad | m]."""


class JointTrajectoryController:
    """Follows a joint trajectory.

    Velocity and effort joints are controlled with a PID and feed-forward.

    The command is the desired motion one period ahead, whereas errors refer to the
    current desired motion.  A trajectory that is received between ticks starts in the
    next tick, from the motion measured in that tick.

    The controller behaves like the ROS 2 controller of the same name, with these
    improvements:

    * if the command of a goal times out, the goal is aborted, whereas ROS reports such
      a goal as reached;
    * without a goal tolerance, a joint must come within DEFAULT_GOAL_TOLERANCE;
    * if a trajectory ends with a nonzero velocity, the joints must come to rest
      afterwards;
    * continuous joints move to the nearest equivalent angle of a point, instead of
      jumping to the angle that the point specifies;
    * goals are also rejected for the reasons that ``trajectory_check`` describes.

    A motion planned by the simulator starts from the desired motion.
    """

    def __init__(
        self, spec: JointTrajectorySpec, indices: Sequence[int], state: JointState
    ) -> None:
        self.spec = spec
        self._tracking = JointTracking(
            spec.joint_models, spec.gains, spec.velocity_ff, indices, state
        )
        self.pid = self._tracking.pid
        self._take_tolerances(spec.tolerances)
        self._monitor: TrajectoryMonitor | None = None
        """Monitor of the trajectory; None while the joints hold a position."""
        self._factor = spec.speed.initial
        """Speed factor that was last set through the topic."""
        self._factor_used = 1.0
        self._clock = TrajectoryClock()
        self._period = 0.0
        self._pending: _PendingTrajectory | None = None
        """Trajectory that starts in the next tick, from the measured motion; None if
        there is no such trajectory."""
        self._is_first = True
        """Whether the next tick is the first tick of a trajectory."""
        self._has_points = False
        """Whether the motion has several points, so that another motion can continue
        it."""
        self._execute(self._tracking.sampler.splines)

    # ---- the tick -----------------------------------------------------------------

    def update(self, state: JointState, period: float) -> Sequence[float]:
        """Return the desired positions, or efforts or speeds that lead toward them."""
        tracking, self._period = self._tracking, period
        tracking.state = state
        factor = self.speed_scaling
        if factor != self._factor_used:
            self._factor_used = factor
            self._clock = self._clock.scaled(factor, state.time)
        time, is_first = self._clock.at(state.time), self._is_first
        if is_first:
            self._start_pending(time)
        ahead = time + period
        monitor, pid = self._monitor, self.pid
        errors: list[float] = []
        rates: list[float] = []
        if monitor is not None or pid is not None:
            if time >= tracking.sampler.next_change:
                tracking.sampler.advance(time)
            errors, rates = tracking.errors(time)
            if monitor is not None:
                result = monitor.check(time, ahead, errors, rates, is_first=is_first)
                if result is not None:
                    self._end(result, time, errors)
        commanded = self._ahead
        if ahead >= commanded.next_change:
            commanded.advance(ahead)
        desired, velocities = commanded.desired(ahead)
        if pid is None:
            return desired
        commands = pid.update(errors, rates, period)
        for k, scale in enumerate(tracking.feed_forward):
            commands[k] += scale * velocities[k]
        return commands

    def _start_pending(self, time: float) -> None:
        """Start the pending trajectory, if there is one, from the measured motion."""
        self._is_first = False
        pending, self._pending = self._pending, None
        if pending is not None:
            # Apart from rounding errors, the trajectory is as plausible as it was when
            # it was accepted.
            joints, origins = self.spec.joint_models, self._measured()
            with contextlib.suppress(GoalRejectedError):
                splines = splines_at_once(joints, pending[0], time, origins, pending[1])
                self._execute(splines)

    def law(self) -> TrajectoryLaw | None:
        if self._is_first or self.speed_scaling != self._factor_used:
            return None
        replacement = self.spec.replacement
        is_python = replacement.is_stepped or replacement.upsamples
        return self._tracking.law(self._monitor)._replace(
            lead=self._period,
            clock=self._clock,
            start=None if is_python else self._coming,
            has_points=self._has_points,
        )

    def observe(self, state: JointState) -> None:
        self._tracking.state = state

    def adjust(self, spec: JointTrajectorySpec) -> None:
        """Continue with changed parameters.

        Changed tolerances apply to the next goal and later goals.
        """
        self.spec = spec
        self._tracking.set_feed_forward(spec.velocity_ff)
        self._take_tolerances(self._tolerances)

    def _take_tolerances(self, tolerances: TrajectoryTolerances) -> None:
        """Use ``tolerances`` for the next trajectory and later trajectories."""
        spec, self._tolerances = self.spec, tolerances
        path, at_goal = active_tolerances(
            tolerances, spec.joints, by_velocity=spec.judges_velocity
        )
        self._coming = TrajectoryStart(
            spec.replacement.is_spliced,
            spec.replacement.from_desired,
            spec.reads_velocity,
            spec.acceptance.allows_moving_end,
            path,
            at_goal,
            tolerances.goal_time,
            spec.command_timeout,
        )

    def resume_from_kernel(
        self,
        splines: Mapping[int, JointSpline],
        now: float,
        *,
        is_first: bool,
        has_points: bool,
    ) -> None:
        self._pending = None
        self._start(self._tracking.merged(splines), None)
        self._is_first, self._has_points = is_first, has_points

    def _execute(self, splines: Sequence[JointSpline]) -> None:
        """Follow other splines, which the samplers first use in the next tick."""
        self._tracking.follow(splines, -math.inf)
        self._ahead = TrajectorySampler(splines, -math.inf)

    def _end(
        self, result: GoalResult, time: float, errors: Sequence[float] = ()
    ) -> None:
        """End the trajectory and its goal.

        If the trajectory's end was reached, the joints stay at the end; otherwise, the
        joints stop.
        """
        goal = None if self._monitor is None else self._monitor.goal
        if result.is_violation and errors:
            result = self._with_joint(result, errors)
        if result.status is GoalStatus.ABORTED:
            self._log(result, goal, errors)
        if result.status is not GoalStatus.SUCCEEDED:
            self._come_to_rest(time)
        self._finish(result)
        self._monitor = None

    def _finish(self, result: GoalResult) -> None:
        if self._monitor is not None and self._monitor.goal is not None:
            self._monitor.goal.finish(result)

    def _with_joint(self, result: GoalResult, errors: Sequence[float]) -> GoalResult:
        """Add the joint with the largest error to the result of a violation.

        ROS only logs the joint with the largest error.
        """
        error, joint = max(zip(map(abs, errors), self.spec.joints, strict=True))
        text = f"{result.error_string}; {joint} is off by {error:.6f}"
        return replace(result, error_string=text)

    def _log(
        self, result: GoalResult, goal: Goal | None, errors: Sequence[float]
    ) -> None:
        where = ", ".join(
            f"{joint} {error:.6f}"
            for joint, error in zip(self.spec.joints, errors, strict=True)
        )
        what = result.error_string if goal is not None else "Holding position"
        logger.warning("%s: %s; position errors: %s", self.spec.name, what, where)

    def _come_to_rest(self, time: float) -> None:
        """Hold the measured position immediately, or decelerate to rest."""
        state, select = self._tracking.state, self._tracking.select
        position, velocity = select(state.position), select(state.velocity)
        if self.spec.deceleration:
            motion = zip(position, velocity, self.spec.deceleration, strict=True)
            splines = [decelerated(time, q, qd, rate) for q, qd, rate in motion]
        else:
            splines = [hold(time, q) for q in position]
        self._pending, self._has_points = None, False
        self._execute(splines)

    # ---- requests, between ticks --------------------------------------------------

    def follow(self, goal: TrajectoryGoal | MotionPlan, now: float) -> Goal:
        """Replace the motion with ``goal`` and return its handle, or reject the goal.

        A plan starts with the desired motion at ``now``.

        Raises:
            GoalRejectedError: If the goal is rejected; the previous motion continues.
        """
        handle = Goal(self.spec.name)
        splines = self._accept(goal, now)
        self._finish(REPLACED)
        self._take_tolerances(
            self._tolerances_of(goal)
            if isinstance(goal, TrajectoryGoal)
            else self.spec.tolerances
        )
        self._start(splines, handle)
        return handle

    def _tolerances_of(self, goal: TrajectoryGoal) -> TrajectoryTolerances:
        """Return the tolerances that apply to a goal."""
        return override_tolerances(goal, self.spec.tolerances, self.spec.name)

    def command(self, goal: TrajectoryGoal | MotionPlan, now: float) -> None:
        """Follow a goal from the topic ``~/joint_trajectory``, or reject the goal.

        An active goal stays active, but its result depends on the new motion.
        """
        replacement = self.spec.replacement
        if replacement.upsamples and isinstance(goal, TrajectoryGoal):
            goal = upsampled(goal, replacement.policy_frequency)
        splines = self._accept(goal, now)
        self._start(splines, None if self._monitor is None else self._monitor.goal)

    def cancel(self, goal: Goal, now: float) -> None:
        """Stop if ``goal`` is the active goal, and end it with the status PREEMPTED."""
        if self._monitor is not None and goal is self._monitor.goal:
            self.stop_motion(now)

    def stop_motion(self, now: float) -> None:
        """Stop the joints, and end the active goal with the status PREEMPTED."""
        self._end(CANCELED, self._clock.at(now))

    def stop(self) -> None:
        self._finish(DEACTIVATED)
        self._monitor = None

    @property
    def speed_scaling(self) -> float:
        """Ratio of trajectory time to simulated time."""
        return self.spec.speed.factor(self._factor)

    def scale_speed(self, factor: float) -> None:
        """Scale the speed of trajectories, as ``~/speed_scaling_input`` does.

        Raises:
            ControlError: If the factor is negative, or the topic cannot set the speed.
        """
        self.spec.speed.check(factor, self.spec.name)
        self._factor = factor

    def _accept(
        self, goal: TrajectoryGoal | MotionPlan, now: float
    ) -> Sequence[JointSpline]:
        """Return the splines of a goal, or reject the goal."""
        spec, running = self.spec, self._tracking.sampler.splines
        lag = self._clock.lag_at(now)
        time = now - lag
        if not isinstance(goal, TrajectoryGoal):
            splines = splines_by_plan(spec.joint_models, running, goal, time)
            self._pending, self._has_points = None, True
            return splines
        names = check_goal(goal, spec.acceptance, now)
        start = goal.stamp - lag if goal.stamp else time
        course = Course(goal, names, start, spec.replacement.is_stepped)
        pending = None
        follows = self._can_follow(course)
        if follows:
            start = time + max(start - time, 0.0) * self.speed_scaling
            course = course._replace(start=start).integrated(self._desired(start))
            self._check_limits(course, time)
            splines = splines_spliced(spec.joint_models, running, course, time)
        else:
            desired, measured = self._desired(time), self._measured()
            held = desired if spec.interface is Interface.POSITION else measured
            places = {name: motion.position for name, motion in held.items()}
            origins = desired if spec.replacement.from_desired else measured
            self._check_limits(course.integrated(origins), time)
            joints = spec.joint_models
            splines = splines_at_once(joints, course, time, origins, places)
            if not spec.replacement.from_desired:
                pending = _PendingTrajectory(course, places)
        self._pending = pending
        self._has_points = follows or len(goal.points) > 1
        return splines

    def _can_follow(self, course: Course) -> bool:
        """Return whether a trajectory can continue the current trajectory."""
        is_whole = len(course.names) == len(self.spec.joints)
        return (
            self.spec.replacement.is_spliced
            and self._monitor is not None
            and self._has_points
            and (is_whole or bool(course.goal.points[-1].positions))
        )

    def _check_limits(self, course: Course, time: float) -> None:
        models = dict(zip(self.spec.joints, self.spec.joint_models, strict=True))

        def starts() -> list[float]:
            desired = self._desired(time)
            return [desired[name].position for name in course.names]

        joints = [models[name] for name in course.names]
        check_limits(course.goal, joints, 0, starts)

    def _desired(self, time: float) -> dict[str, Motion]:
        """Return the desired motion of each joint at a trajectory time [s]."""
        splines = self._tracking.sampler.splines
        return {
            joint: Motion(*spline.sample(time))
            for joint, spline in zip(self.spec.joints, splines, strict=True)
        }

    def _measured(self) -> dict[str, Motion]:
        """Return the measured motion of each joint."""
        spec, state, select = self.spec, self._tracking.state, self._tracking.select
        speeds = select(state.velocity)
        if not spec.reads_velocity:
            speeds = [0.0] * len(speeds)
        motion = zip(spec.joints, select(state.position), speeds, strict=True)
        return {joint: Motion(q, qd, 0.0) for joint, q, qd in motion}

    def _start(self, splines: Sequence[JointSpline], handle: Goal | None) -> None:
        """Execute accepted splines, starting with the next tick."""
        coming = self._coming
        self._execute(splines)
        self._is_first = True
        self._monitor = TrajectoryMonitor(
            handle,
            end=max(spline.end for spline in splines),
            path=coming.path,
            at_goal=coming.at_goal,
            goal_time=coming.goal_time,
            timeout=coming.timeout,
        )

    # ---- desired and measured motion ----------------------------------------------

    def query_state(self, time: float) -> JointsMotion:
        """Return the desired motion at ``time`` [s].

        Raises:
            ControlError: If the trajectory at ``time`` is no longer known.
        """
        at, sampler = self._clock.at(time), self._tracking.sampler
        if time < self._tracking.state.time:
            return joints_motion(sampler.samples(at))
        return joints_motion([spline.sample(at) for spline in sampler.splines])

    def setpoint(self) -> Setpoint:
        return self._tracking.setpoint(
            lag=self._clock.lag_at(self._tracking.state.time),
            speed_scaling=self.speed_scaling,
        )
