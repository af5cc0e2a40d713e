"""Whether a trajectory goal keeps its tolerances, and when it has arrived."""

from __future__ import annotations

import math
from typing import final

from tool0.control.goal import Goal, GoalResult, GoalStatus
from tool0.control.sampler import TrajectorySampler

SUCCEEDED = GoalResult(status=GoalStatus.SUCCEEDED)


@final
class GoalMonitor:
    """Checks one active goal in every tick.

    Old segments that are still executed when a goal starts are not checked.  As in ROS,
    each joint that was within its goal tolerances once counts as arrived.
    """

    def __init__(
        self, goal: Goal, joint_names: tuple[str, ...], goal_time: float
    ) -> None:
        """Begin with a goal.

        Args:
            goal: The goal.
            joint_names: The joints of the sampler.
            goal_time: Grace after the last point [s].
        """
        self.goal = goal
        self._joint_names = joint_names
        self._goal_time = goal_time
        self._arrived: set[int] = set()

    def watch(self, sampler: TrajectorySampler, time: float) -> None:
        """Collect what to check until the sampler's next change."""
        self._current = sampler.current
        self._on_path: list[int] = []
        self._at_goal: list[int] = []
        self._path_limit = math.inf
        self._checks_path_velocity = False
        for k, ((section, segment), is_at_end) in enumerate(
            zip(sampler.current, sampler.arrived, strict=True)
        ):
            if section.goal is not self.goal:
                continue
            if is_at_end:
                if k not in self._arrived:
                    self._at_goal.append(k)
                continue
            if segment.end <= time:
                continue
            path = section.tolerances.path
            if path.position > 0.0 or path.velocity > 0.0:
                self._on_path.append(k)
                self._path_limit = min(self._path_limit, path.position or math.inf)
                self._checks_path_velocity |= path.velocity > 0.0

    def check(
        self, time: float, errors: list[float], rates: list[float]
    ) -> GoalResult | None:
        """Return how the goal ends, or None while it goes on.

        Args:
            time: Of the errors [s].
            errors: Desired minus measured positions [rad | m].
            rates: Desired minus measured velocities [rad/s | m/s].
        """
        if self._on_path and (
            self._checks_path_velocity or max(map(abs, errors)) > self._path_limit
        ):
            for k in self._on_path:
                path = self._current[k][0].tolerances.path
                if not path.allows(errors[k], rates[k]):
                    code = GoalResult.PATH_TOLERANCE_VIOLATED
                    return self._violation(code, "path", k, errors[k])
        return self._check_arrival(time, errors, rates) if self._at_goal else None

    def _check_arrival(
        self, time: float, errors: list[float], rates: list[float]
    ) -> GoalResult | None:
        waiting = []
        for k in self._at_goal:
            section, segment = self._current[k]
            if section.tolerances.goal.allows(errors[k], rates[k]):
                self._arrived.add(k)
            elif time < segment.end + self._goal_time:
                waiting.append(k)
            else:
                code = GoalResult.GOAL_TOLERANCE_VIOLATED
                return self._violation(code, "goal", k, errors[k])
        self._at_goal = waiting
        return SUCCEEDED if len(self._arrived) == len(errors) else None

    def _violation(self, code: int, kind: str, k: int, error: float) -> GoalResult:
        return GoalResult(
            status=GoalStatus.ABORTED,
            error_code=code,
            error_string=f"{self._joint_names[k]} {kind} error {error:.6f}",
        )
