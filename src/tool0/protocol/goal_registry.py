"""Registry of goals by number."""

from __future__ import annotations

import threading
from typing import final

from tool0.errors import ControlError
from tool0.protocol.goals import Goal

GOALS_KEPT = 1000
"""Maximum number of stored goals; the oldest finished goals are dropped."""


@final
class GoalRegistry:
    """Assigns numbers to goals, and finds goals by number; thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._goals: dict[int, Goal] = {}
        self._last = 0

    def add(self, goal: Goal, number: int | None = None) -> int:
        """Store ``goal`` and return its number; the default is the next free number."""
        with self._lock:
            if number is None:
                self._last = number = self._last + 1
            self._goals[number] = goal
            if len(self._goals) > GOALS_KEPT:
                ended = (n for n, g in self._goals.items() if g.status.is_terminal)
                oldest = next(ended, None)
                if oldest is not None:
                    del self._goals[oldest]
            return number

    def active(self) -> tuple[Goal, ...]:
        """Return the goals that have not ended, oldest first."""
        with self._lock:
            goals = tuple(self._goals.values())
        return tuple(goal for goal in goals if not goal.status.is_terminal)

    def number(self, goal: Goal) -> int | None:
        """Return a goal's number; None if it has no number or was dropped."""
        with self._lock:
            found = (number for number, item in self._goals.items() if item is goal)
            return next(found, None)

    def find(self, number: int) -> Goal:
        """Return a goal, or raise ControlError if there is no goal with this number."""
        with self._lock:
            goal = self._goals.get(number)
        if goal is None:
            raise ControlError(
                f"there is no goal {number}; the last {GOALS_KEPT} are kept"
            )
        return goal
