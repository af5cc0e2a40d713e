"""Goals and their outcomes: a fault is an exception, an outcome is a value."""

from __future__ import annotations

import enum
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import final


class GoalStatus(enum.Enum):
    """The states of actionlib that a person sees."""

    ACTIVE = "ACTIVE"
    SUCCEEDED = "SUCCEEDED"
    ABORTED = "ABORTED"
    PREEMPTED = "PREEMPTED"

    def __repr__(self) -> str:
        """Return the bare name, as ROS prints it."""
        return self.value

    @property
    def is_terminal(self) -> bool:
        return self is not GoalStatus.ACTIVE


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class GoalResult:
    """How a trajectory goal ended: control_msgs/FollowJointTrajectoryResult."""

    PATH_TOLERANCE_VIOLATED = -4
    GOAL_TOLERANCE_VIOLATED = -5

    status: GoalStatus
    error_code: int = 0
    error_string: str = ""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class GripperResult:
    """How a gripper goal ended: control_msgs/GripperCommandResult, joint units."""

    status: GoalStatus
    position: float
    """[rad | m]"""
    effort: float
    """[N·m | N]"""
    stalled: bool
    reached_goal: bool


Result = GoalResult | GripperResult


@final
class Goal:
    """A goal that a controller accepted.  Only its controller finishes it.

    Reading is safe from any thread.
    """

    def __init__(self, controller: str) -> None:
        self.controller = controller
        self._result: Result | None = None
        self._finished = threading.Event()
        self._callbacks: list[Callable[[Goal], None]] = []
        self._lock = threading.Lock()

    @property
    def status(self) -> GoalStatus:
        return GoalStatus.ACTIVE if self._result is None else self._result.status

    @property
    def result(self) -> Result | None:
        """How it ended; None while it is active."""
        return self._result

    def finish(self, result: Result) -> None:
        """Set the outcome, once; later calls change nothing."""
        with self._lock:
            if self._result is not None:
                return
            self._result = result
            callbacks, self._callbacks = self._callbacks, []
        self._finished.set()
        for callback in callbacks:
            callback(self)

    def when_finished(self, callback: Callable[[Goal], None]) -> None:
        """Call ``callback(goal)`` when it ends, in the thread that ends it."""
        with self._lock:
            if self._result is None:
                self._callbacks.append(callback)
                return
        callback(self)

    def wait(self, timeout: float | None) -> bool:
        """Block for at most ``timeout`` wall seconds; return whether it ended."""
        return self._finished.wait(timeout)
