"""JointTrajectoryController: follow trajectories, and hold still without one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

from tool0.control import goal_check
from tool0.control.angles import shortest_turn
from tool0.control.goal import Goal, GoalResult, GoalStatus
from tool0.control.intent import TrajectoryIntent
from tool0.control.joint_trajectory_spec import JointTrajectorySpec
from tool0.control.merging import merged_tracks, planned_tracks, stopping_tracks
from tool0.control.pid import PidBank
from tool0.control.playback import Playback, hold_track
from tool0.control.segment import MotionPlan
from tool0.control.track import Track
from tool0.control.trajectory import (
    JointsMotion,
    TrajectoryGoal,
    TrajectoryState,
)
from tool0.description.model import JointType
from tool0.hardware.joint_state import JointState
from tool0.hardware.pick import picker


@final
class JointTrajectoryController:
    """Track a joint trajectory; effort and velocity joints by PID and feed-forward.

    Time is the absolute simulated time of the states.  Goals come between ticks, with
    ``now`` the time of the coming one: a goal without a stamp starts exactly then.

    It behaves as ROS 1's controller of that name, but for these of its faults:

    * a goal that violates a tolerance is aborted and the joints stop, by the same ramp
      as after a cancel, instead of executing on;
    * position errors are wrapped for continuous joints only, not for joints whose
      limits span more than a turn, nor for prismatic ones;
    * without ``constraints/goal_time`` a goal gets DEFAULT_GOAL_TIME to come to rest;
    * what ``goal_check`` says is rejected;
    * the stop ramp does not end beyond a joint's limits.

    As in ROS, each joint that was within its goal tolerances once counts as arrived.
    """

    def __init__(
        self, spec: JointTrajectorySpec, indices: Sequence[int], state: JointState
    ) -> None:
        self.spec = spec
        self._pick = picker(indices)
        self._wrapping = [
            k
            for k, joint in enumerate(spec.joint_models)
            if joint.type is JointType.CONTINUOUS
        ]
        self._law = PidBank(spec.gains) if spec.gains else None
        self._feed_forward = spec.velocity_ff if any(spec.velocity_ff) else ()
        self._tolerances = spec.tolerances
        self._goal: Goal | None = None
        self._done: set[int] = set()
        self._goal_time = 0.0
        self._state = state
        position = self._pick(state.position)
        self._playback = Playback(
            [hold_track(state.time, q) for q in position], state.time
        )
        self._watch(state.time)

    @property
    def active_goal(self) -> Goal | None:
        """The goal that is being followed."""
        return self._goal

    # ---- the tick -----------------------------------------------------------------

    def update(self, state: JointState, period: float) -> Sequence[float]:
        """Return the commands: desired positions, or velocities or efforts to them."""
        self._state = state
        time, position, velocity, _ = state
        playback = self._playback
        if time >= playback.next_change:
            playback.advance(time)
            self._watch(time)
        law = self._law
        if law is None and self._goal is None:
            return playback.desired(time)[0]
        speeds = self._pick(velocity)
        errors, rates = playback.errors(time, self._pick(position), speeds)
        for k in self._wrapping:
            errors[k] = shortest_turn(0.0, errors[k])
        if self._goal is not None:
            self._judge(self._goal, time, errors, rates)
        if law is None:
            return playback.desired(time)[0]
        commands = law.update(errors, rates, period)
        if self._feed_forward:
            for k, scale in enumerate(self._feed_forward):
                commands[k] += scale * (rates[k] + speeds[k])
        return commands

    def _watch(self, time: float) -> None:
        """Collect what to check until the next change, so that the tick does less."""
        self._on_path: list[int] = []
        self._at_goal: list[int] = []
        self._path_limit = float("inf")
        self._checks_path_velocity = False
        if self._goal is None:
            return
        playback = self._playback
        for k, (piece, arrived) in enumerate(
            zip(playback.current, playback.arrived, strict=True)
        ):
            if piece.goal is not self._goal:
                continue
            if arrived:
                if k not in self._done:
                    self._at_goal.append(k)
                continue
            if piece.segment.end <= time:
                continue
            path = piece.tolerances.path
            if path.position > 0.0 or path.velocity > 0.0:
                self._on_path.append(k)
                self._path_limit = min(self._path_limit, path.position or float("inf"))
                self._checks_path_velocity |= path.velocity > 0.0

    def _judge(
        self, goal: Goal, time: float, errors: list[float], rates: list[float]
    ) -> None:
        """Abort the goal on a violated tolerance; end it when every joint arrived."""
        if self._on_path and (
            self._checks_path_velocity or max(map(abs, errors)) > self._path_limit
        ):
            for k in self._on_path:
                path = self._playback.current[k].tolerances.path
                if not path.allows(errors[k], rates[k]):
                    self._abort(goal, "path", k, errors[k])
                    return
        if self._at_goal:
            self._judge_arrival(goal, time, errors, rates)

    def _judge_arrival(
        self, goal: Goal, time: float, errors: list[float], rates: list[float]
    ) -> None:
        waiting = []
        for k in self._at_goal:
            piece = self._playback.current[k]
            if piece.tolerances.goal.allows(errors[k], rates[k]):
                self._done.add(k)
            elif time < piece.segment.end + self._goal_time:
                waiting.append(k)
            else:
                self._abort(goal, "goal", k, errors[k])
                return
        self._at_goal = waiting
        if len(self._done) == len(errors):
            self._end_goal(GoalStatus.SUCCEEDED)

    def _abort(self, goal: Goal, kind: str, k: int, error: float) -> None:
        code = {
            "path": GoalResult.PATH_TOLERANCE_VIOLATED,
            "goal": GoalResult.GOAL_TOLERANCE_VIOLATED,
        }[kind]
        text = f"{self.spec.joints[k]} {kind} error {error:.6f}"
        self._goal = None
        self._play(self._stop_tracks(self._state.time, None), self._state.time)
        goal.finish(
            GoalResult(status=GoalStatus.ABORTED, error_code=code, error_string=text)
        )

    def _end_goal(self, status: GoalStatus) -> None:
        goal, self._goal = self._goal, None
        if goal is not None:
            self._on_path, self._at_goal = [], []
            goal.finish(GoalResult(status=status))

    # ---- requests, between ticks --------------------------------------------------

    def follow(self, goal: TrajectoryGoal, now: float) -> Goal:
        """Replace what is done by ``goal`` and return its handle, or reject it.

        Raises:
            GoalRejectedError: With ROS's code; what ran before goes on untouched.
        """
        handle = Goal(self.spec.name)
        self._accept(goal, now, handle)
        return handle

    def command(self, goal: TrajectoryGoal, now: float) -> None:
        """Replace what is done by ``goal``, without tolerances, or reject it.

        The topic ``~/command`` of ROS: nobody hears whether it arrives.
        """
        self._accept(goal, now, None)

    def follow_plan(self, plan: MotionPlan, now: float) -> Goal:
        """Replace what is done by a plan that starts as the joints are wanted ``now``.

        Raises:
            GoalRejectedError: If no joint can move so; what ran before goes on.
        """
        handle = Goal(self.spec.name)
        self._accept_plan(plan, now, handle)
        return handle

    def command_plan(self, plan: MotionPlan, now: float) -> None:
        """Replace what is done by such a plan, without tolerances, or reject it."""
        self._accept_plan(plan, now, None)

    def cancel(self, goal: Goal, now: float) -> None:
        """Stop, if ``goal`` is the active one; it ends PREEMPTED."""
        if goal is self._goal and goal is not None:
            self._play(self._stop_tracks(now, None), now)
            self._end_goal(GoalStatus.PREEMPTED)

    def stop(self) -> None:
        """End an active goal as PREEMPTED; the controller is dropped after that."""
        self._end_goal(GoalStatus.PREEMPTED)

    def _accept(self, goal: TrajectoryGoal, now: float, handle: Goal | None) -> None:
        names = goal_check.check_names(
            goal,
            self.spec.joints,
            allow_partial=self.spec.allow_partial_joints_goal,
        )
        if goal.points:
            tracks = merged_tracks(
                self.spec, self._playback.tracks, goal, names, now=now, handle=handle
            )
        else:
            tracks = self._stop_tracks(now, handle)
        self._replace(tracks, now, handle, goal.goal_time_tolerance)

    def _accept_plan(self, plan: MotionPlan, now: float, handle: Goal | None) -> None:
        old = self._playback.tracks
        tracks = planned_tracks(self.spec, old, plan, now=now, handle=handle)
        self._replace(tracks, now, handle, None)

    def _replace(
        self,
        tracks: list[Track],
        now: float,
        handle: Goal | None,
        goal_time: float | None,
    ) -> None:
        self._end_goal(GoalStatus.PREEMPTED)
        self._goal = handle
        self._done = set()
        self._goal_time = self._tolerances.goal_time_with(goal_time)
        self._play(tracks, now)

    def _stop_tracks(self, now: float, handle: Goal | None) -> list[Track]:
        measured = self._pick(self._state.position)
        return stopping_tracks(self.spec, self._playback.tracks, measured, now, handle)

    def _play(self, tracks: list[Track], time: float) -> None:
        self._playback = Playback(tracks, time)
        self._watch(time)

    # ---- what it wants and has ----------------------------------------------------

    def query_state(self, time: float) -> JointsMotion:
        """Return what is wanted of the joints at ``time``.

        Raises:
            ControlError: If no trajectory is known so far back.
        """
        motions = self._playback.motions(time)
        return JointsMotion(
            positions=tuple(motion.position for motion in motions),
            velocities=tuple(motion.velocity for motion in motions),
            accelerations=tuple(motion.acceleration for motion in motions),
        )

    def intent(self) -> TrajectoryIntent:
        """Return what is wanted and measured, as a value that later ticks leave be."""
        return TrajectoryIntent(
            self.spec.joint_models, self._playback.tracks, self._pick, self._state
        )

    def state(self) -> TrajectoryState:
        """Return what was wanted and measured at the last update."""
        return self.intent().state()
