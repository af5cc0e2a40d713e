"""JointTrajectoryController: follows trajectories, or holds a position."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, final

from tool0.control.goal_motion import splines_by_plan
from tool0.control.joint_tracking import JointTracking
from tool0.control.law import TrajectoryLaw
from tool0.control.parameters import (
    INTERFACE_OF_PACKAGE,
    RobotJoints,
    controlled_joints,
    read_gains,
    read_tolerances,
)
from tool0.control.ros1.goal_check import (
    TrajectoryReplacement,
    check_names,
    goal_time_with,
)
from tool0.control.sampler import GoalMonitor
from tool0.control.spline import JointSpline, MotionPlan
from tool0.control.tolerances import DEFAULT_GOAL_TIME, TrajectoryTolerances
from tool0.control.trajectory import Setpoint, TrajectoryGoal, joints_motion
from tool0.description.model import Interface, Joint
from tool0.description.yaml_values import Namespace
from tool0.hardware.engine import JointState
from tool0.hardware.limits import PUSHING
from tool0.protocol.controllers import Gains
from tool0.protocol.goals import Goal, GoalResult, GoalStatus
from tool0.protocol.trajectories import JointsMotion

RELIEF = 0.005
"""Distance by which a joint that pushes at its effort limit backs off in a stop [rad |
m].  The joint backs off because the contact is compressed; in Gazebo, the compression
is 2 mrad."""

PREEMPTED = GoalResult(status=GoalStatus.PREEMPTED)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class JointTrajectorySpec:
    """The parameters of a JointTrajectoryController."""

    name: str
    type: str
    joint_models: tuple[Joint, ...]
    interface: Interface
    gains: tuple[Gains, ...] = ()
    """Gains of each joint; empty for the position interface."""
    velocity_ff: tuple[float, ...] = ()
    """Feed-forward factors from desired velocity to command, one per joint; empty for
    the position interface."""
    tolerances: TrajectoryTolerances
    stop_trajectory_duration: float = 0.0
    """Duration of the ramp to rest [s]; if it is 0, the measured position is held
    immediately."""
    allow_partial_joints_goal: bool = False
    state_publish_rate: float = 50.0
    """Publication rate of the state in ROS [Hz]; a rate of 0 disables publication."""
    action_monitor_rate: float = 20.0
    """Rate of the feedback of the ROS action [Hz]."""

    further_interfaces: ClassVar[tuple[str, ...]] = ()
    state_interfaces: ClassVar[tuple[str, ...]] = ()
    waits_for_command: ClassVar[bool] = False

    @property
    def joints(self) -> tuple[str, ...]:
        return tuple(joint.name for joint in self.joint_models)

    def start(
        self, indices: Sequence[int], state: JointState
    ) -> JointTrajectoryController:
        return JointTrajectoryController(self, indices, state)


@final
class JointTrajectoryController:
    """Follows a joint trajectory.

    Effort and velocity joints are controlled with a PID and feed-forward.

    Time is the absolute simulated time of the states.  Goals are handled between ticks;
    the argument ``now`` is the time of the next tick.  A goal without a stamp starts at
    ``now``.

    The controller behaves like the ROS 1 controller of the same name, with these
    improvements:

    * a goal that violates a tolerance is aborted, and the joints stop with the same
      ramp as after a cancellation, instead of continuing the trajectory;
    * if the joints do not follow the trajectory, the stop ramp starts from the measured
      motion;
    * in a stop, the integral of a joint that pushes at its effort limit is reset, and
      the joint backs off by RELIEF, so that it does not continue to push;
    * position errors are wrapped for continuous joints only, not for prismatic joints
      or for joints with limits that span more than one turn;
    * without ``constraints/goal_time``, the joints may take DEFAULT_GOAL_TIME to come
      to rest;
    * without a goal tolerance, a joint must come within DEFAULT_GOAL_TOLERANCE;
    * goals are also rejected for the reasons that ``goal_check`` describes;
    * the stop ramp does not end beyond a joint's limits.

    As in ROS, a joint is considered to have arrived after it has been within its goal
    tolerances once.
    """

    def __init__(
        self, spec: JointTrajectorySpec, indices: Sequence[int], state: JointState
    ) -> None:
        self.spec = spec
        self._tracking = JointTracking(
            spec.joint_models, spec.gains, spec.velocity_ff, indices, state
        )
        self.pid = self._tracking.pid
        self._replacement = TrajectoryReplacement(
            spec.joint_models, spec.tolerances, spec.stop_trajectory_duration
        )
        self._monitor: GoalMonitor | None = None

    # ---- the tick -----------------------------------------------------------------

    def update(self, state: JointState, period: float) -> Sequence[float]:
        """Return the desired positions, or efforts or speeds that lead toward them."""
        tracking, monitor, time = self._tracking, self._monitor, state.time
        tracking.state = state
        sampler = tracking.sampler
        if time >= sampler.next_change:
            sampler.advance(time)
            if monitor is not None:
                monitor.watch(sampler)
        pid = self.pid
        if pid is None and monitor is None:
            return sampler.desired(time)[0]
        errors, rates = tracking.errors(time)
        if monitor is not None:
            result = monitor.check(time, errors, rates)
            if result is not None:
                self._end_goal(result)
        if pid is None:
            return sampler.desired(time)[0]
        commands = pid.update(errors, rates, period)
        if tracking.feed_forward:
            speeds = tracking.select(state.velocity)
            for k, scale in enumerate(tracking.feed_forward):
                commands[k] += scale * (rates[k] + speeds[k])
        return commands

    def law(self) -> TrajectoryLaw:
        return self._tracking.law(self._monitor)

    def observe(self, state: JointState) -> None:
        self._tracking.state = state

    def resume_from_kernel(
        self,
        splines: Mapping[int, JointSpline],
        now: float,
        *,
        is_first: bool,
        has_points: bool,
    ) -> None:
        """Continue with the motions that the kernel started; keys are joint indices."""
        self._end_goal(PREEMPTED)
        self._tracking.follow(self._tracking.merged(splines), now)

    def _end_goal(self, result: GoalResult) -> None:
        """End the active goal, if there is one.

        If the goal is aborted, the joints stop.
        """
        monitor, self._monitor = self._monitor, None
        if result.status is GoalStatus.ABORTED:
            now = self._tracking.state.time
            self._tracking.follow(self._stop_splines(now, None), now)
        if monitor is not None:
            monitor.goal.finish(result)

    # ---- requests, between ticks --------------------------------------------------

    def follow(self, goal: TrajectoryGoal | MotionPlan, now: float) -> Goal:
        """Replace the motion with ``goal`` and return its handle, or reject the goal.

        A plan starts with the desired motion at ``now``.

        Raises:
            GoalRejectedError: If the goal is rejected, with the error code of ROS; the
                previous motion continues.
        """
        handle = Goal(self.spec.name)
        self._accept(goal, now, handle)
        return handle

    def command(self, goal: TrajectoryGoal | MotionPlan, now: float) -> None:
        """Replace the motion with ``goal``, without tolerances, or reject the goal.

        ``command`` corresponds to the ROS topic ``~/command``, which reports no result.
        """
        self._accept(goal, now, None)

    def cancel(self, goal: Goal, now: float) -> None:
        """Stop if ``goal`` is the active goal, and end it with the status PREEMPTED."""
        if self._monitor is not None and goal is self._monitor.goal:
            self.stop_motion(now)

    def stop_motion(self, now: float) -> None:
        """Stop the joints, and end the active goal with the status PREEMPTED."""
        self._tracking.follow(self._stop_splines(now, None), now)
        self._end_goal(PREEMPTED)

    def stop(self) -> None:
        self._end_goal(PREEMPTED)

    def _accept(
        self, goal: TrajectoryGoal | MotionPlan, now: float, handle: Goal | None
    ) -> None:
        spec, tracking, goal_time = self.spec, self._tracking, None
        running = tracking.sampler.splines
        if isinstance(goal, TrajectoryGoal):
            names = check_names(
                goal, spec.joints, allow_partial=spec.allow_partial_joints_goal
            )
            goal_time = goal.goal_time_tolerance
            if goal.points:
                splines = self._replacement.by_goal(running, goal, names, now, handle)
            else:
                splines = self._stop_splines(now, handle)
        else:
            splines = splines_by_plan(
                spec.joint_models,
                running,
                goal,
                now,
                goal=handle,
                tolerances=spec.tolerances,
            )
        self._end_goal(PREEMPTED)
        tracking.follow(splines, now)
        if handle is not None:
            grace = goal_time_with(spec.tolerances.goal_time, goal_time)
            self._monitor = GoalMonitor(handle, spec.joints, grace)
            self._monitor.watch(tracking.sampler)

    def _stop_splines(self, now: float, handle: Goal | None) -> list[JointSpline]:
        """Return splines that stop the joints.

        Joints at their effort limit back off.
        """
        state, select = self._tracking.state, self._tracking.select
        positions = list(select(state.position))
        for k, effort in enumerate(select(state.effort)):
            limit = self.spec.joint_models[k].limits.effort
            if 0.0 < PUSHING * limit <= abs(effort):
                positions[k] -= math.copysign(RELIEF, effort)
                if self.pid is not None:
                    self.pid.reset(k)
        return self._replacement.by_stop(
            self._tracking.sampler.splines,
            positions,
            select(state.velocity),
            now,
            handle,
        )

    # ---- desired and measured motion ----------------------------------------------

    def query_state(self, time: float) -> JointsMotion:
        """Return the desired motion at ``time`` [s].

        Raises:
            ControlError: If the trajectory at ``time`` is no longer known.
        """
        return joints_motion(self._tracking.sampler.samples(time))

    def setpoint(self) -> Setpoint:
        return self._tracking.setpoint()


def parse(
    name: str, type_name: str, parameters: Namespace, robot: RobotJoints
) -> JointTrajectorySpec:
    """Return the checked parameters of a JointTrajectoryController."""
    interface = INTERFACE_OF_PACKAGE[type_name.partition("/")[0]]
    joints = controlled_joints(robot, parameters, interface)
    gains: tuple[Gains, ...] = ()
    velocity_ff: tuple[float, ...] = ()
    if interface is not Interface.POSITION:
        why = f"{type_name} needs"
        gains = tuple(
            read_gains(parameters, f"gains/{joint.name}", why) for joint in joints
        )
        velocity_ff = tuple(
            parameters.number(f"velocity_ff/{joint.name}", 0.0) for joint in joints
        )
    return JointTrajectorySpec(
        name=name,
        type=type_name,
        joint_models=joints,
        interface=interface,
        gains=gains,
        velocity_ff=velocity_ff,
        tolerances=TrajectoryTolerances(
            joints=read_tolerances(parameters, joints, robot),
            goal_time=parameters.not_negative(
                "constraints/goal_time", DEFAULT_GOAL_TIME
            ),
        ),
        stop_trajectory_duration=parameters.not_negative(
            "stop_trajectory_duration", 0.0
        ),
        allow_partial_joints_goal=parameters.boolean(
            "allow_partial_joints_goal", default=False
        ),
        state_publish_rate=parameters.not_negative("state_publish_rate", 50.0),
        action_monitor_rate=parameters.not_negative("action_monitor_rate", 20.0),
    )
