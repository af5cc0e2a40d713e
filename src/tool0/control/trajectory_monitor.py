"""Monitoring of a trajectory in every tick, for all joints together, as in ROS 2."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import final

from tool0.protocol.goals import Goal, GoalResult, GoalStatus, Tolerance

REACHED = GoalResult(
    status=GoalStatus.SUCCEEDED, error_string="Goal successfully reached!"
)
STRAYED = GoalResult(
    status=GoalStatus.ABORTED,
    error_code=GoalResult.PATH_TOLERANCE_VIOLATED,
    error_string="Aborted due to path tolerance violation",
)
TIMED_OUT = GoalResult(
    status=GoalStatus.ABORTED,
    error_code=GoalResult.GOAL_TOLERANCE_VIOLATED,
    error_string="Aborted due to command timeout",
)


@final
class TrajectoryMonitor:
    """Checks the current trajectory, with or without a goal, in every tick.

    All times are trajectory times.  A trajectory is considered to have ended one period
    early, when its end is commanded.
    """

    def __init__(
        self,
        goal: Goal | None,
        *,
        end: float,
        path: Sequence[Tolerance],
        at_goal: Sequence[Tolerance],
        goal_time: float,
        timeout: float,
    ) -> None:
        """Monitor a trajectory until it has ended and all joints have arrived.

        Args:
            goal: Goal of the trajectory; None for a command from the topic.
            end: Time at which the last joint's motion ends [s].
            path: Tolerances on the path, one per joint.
            at_goal: Tolerances at the goal, one per joint.  All tolerances must be met
                simultaneously.
            goal_time: Time to arrive after the end [s]; inf if the time is unlimited.
            timeout: Time after the end at which the trajectory is aborted [s]; inf if
                it is never aborted.
        """
        self.goal = goal
        self.end = end
        self.path, self.at_goal = tuple(path), tuple(at_goal)
        self.goal_time, self.timeout = goal_time, timeout
        limits = [one.position for one in path if one.position > 0.0]
        self._path_limit = min(limits, default=math.inf)
        self._checks_path_velocity = any(one.velocity > 0.0 for one in path)

    def check(
        self,
        time: float,
        ahead: float,
        errors: Sequence[float],
        rates: Sequence[float],
        *,
        is_first: bool,
    ) -> GoalResult | None:
        """Return the result if the trajectory ends at ``time`` [s], or None.

        ``ahead`` [s] is the time of the commanded motion.  The path tolerances also
        apply in the first tick of a trajectory (``is_first``), even if the trajectory
        has already ended.
        """
        is_moving = ahead < self.end
        if (is_moving or is_first) and not self._is_on_path(errors, rates):
            return STRAYED
        if is_moving:
            return None
        past = time - self.end
        if _allow(self.at_goal, errors, rates):
            if self.goal is not None:
                return REACHED
        elif past > self.goal_time:
            return GoalResult(
                status=GoalStatus.ABORTED,
                error_code=GoalResult.GOAL_TOLERANCE_VIOLATED,
                error_string="Aborted due to goal_time_tolerance exceeding by "
                f"{past:f} seconds",
            )
        return TIMED_OUT if past > self.timeout else None

    def _is_on_path(self, errors: Sequence[float], rates: Sequence[float]) -> bool:
        if not self._checks_path_velocity and max(map(abs, errors)) <= self._path_limit:
            return True
        return _allow(self.path, errors, rates)


def _allow(
    tolerances: Sequence[Tolerance], errors: Sequence[float], rates: Sequence[float]
) -> bool:
    return all(
        tolerance.allows(error, rate)
        for tolerance, error, rate in zip(tolerances, errors, rates, strict=True)
    )
