"""Goals: their status, outcome and tolerances, and requests about goals.

Faults are raised as exceptions; outcomes are returned as values.
"""

from __future__ import annotations

import enum
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, NoReturn, final

from msgspec import Struct

from tool0.errors import ControlError
from tool0.protocol.request import Request


class GoalStatus(enum.Enum):
    """Status of a goal, with the names from actionlib."""

    ACTIVE = "ACTIVE"
    SUCCEEDED = "SUCCEEDED"
    ABORTED = "ABORTED"
    PREEMPTED = "PREEMPTED"

    def __repr__(self) -> str:
        """Return the name of the status, in the notation of ROS."""
        return self.value

    @property
    def is_terminal(self) -> bool:
        """Whether the goal has ended."""
        return self is not GoalStatus.ACTIVE


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class GoalResult:
    """Result of a trajectory goal, like control_msgs/FollowJointTrajectoryResult."""

    INVALID_GOAL = -1
    PATH_TOLERANCE_VIOLATED = -4
    GOAL_TOLERANCE_VIOLATED = -5

    status: GoalStatus
    """SUCCEEDED, ABORTED or PREEMPTED."""
    error_code: int = 0
    """Error code of ROS, such as ``PATH_TOLERANCE_VIOLATED``; 0 without an error."""
    error_string: str = ""
    """Cause of an abort: the joint and its error; empty if the goal succeeded."""

    @property
    def is_violation(self) -> bool:
        """Whether a tolerance was violated."""
        codes = self.PATH_TOLERANCE_VIOLATED, self.GOAL_TOLERANCE_VIOLATED
        return self.error_code in codes


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class GripperResult:
    """Result of a gripper goal, like control_msgs/GripperCommandResult.

    Values are in joint units.
    """

    status: GoalStatus
    """SUCCEEDED, ABORTED or PREEMPTED."""
    position: float
    """Position of the driven joint [rad | m]."""
    effort: float
    """Effort of the drive [N·m | N]."""
    stalled: bool
    """Whether the joint stalled before it reached the goal."""
    reached_goal: bool
    """Whether the joint reached the goal within the tolerance."""
    holds: bool = False
    """Whether the gripper holds an object: both fingers are in contact with it."""
    error_string: str = ""
    """Reason why the joint stopped before the goal; empty if it reached the goal."""


Result = GoalResult | GripperResult


@final
class Goal:
    """A goal that a controller has accepted; only this controller can finish the goal.

    All threads can read the goal safely.
    """

    def __init__(self, controller: str) -> None:
        self.controller = controller
        self._result: Result | None = None
        self._finished = threading.Event()
        self._callbacks: list[Callable[[Goal], None]] = []
        self._lock = threading.Lock()
        self.explain: Callable[[Result], Result] = lambda result: result
        """Function that completes the result with information that the controller does
        not have, such as contacts."""

    def __deepcopy__(self, memo: dict[int, object]) -> NoReturn:
        """Refuse a copy, because a client may wait for the outcome of the original."""
        raise ControlError(
            "it has a goal, which can end only once; cancel it or wait for it"
        )

    @property
    def status(self) -> GoalStatus:
        return GoalStatus.ACTIVE if self._result is None else self._result.status

    @property
    def result(self) -> Result | None:
        """The outcome of the goal; None while it is active."""
        return self._result

    def finish(self, result: Result) -> None:
        """Set the outcome of the goal; only the first call has an effect."""
        with self._lock:
            if self._result is not None:
                return
            self._result = self.explain(result)
            callbacks, self._callbacks = self._callbacks, []
        self._finished.set()
        for callback in callbacks:
            callback(self)

    def when_finished(self, callback: Callable[[Goal], None]) -> None:
        """Call ``callback(goal)`` when the goal ends, in the thread that ends it."""
        with self._lock:
            if self._result is None:
                self._callbacks.append(callback)
                return
        callback(self)

    def wait(self, timeout: float | None) -> bool:
        """Wait up to ``timeout`` [wall s]; return whether the goal has ended."""
        return self._finished.wait(timeout)


class Tolerance(NamedTuple):
    """Maximum allowed errors of one joint; 0 disables a check."""

    position: float = 0.0
    """Position error [rad | m]."""
    velocity: float = 0.0
    """Velocity error [rad/s | m/s]."""
    acceleration: float = 0.0
    """Acceleration error [rad/s² | m/s²].  This tolerance is never checked, because
    neither ROS nor tool0 measures accelerations."""

    def allows(self, position_error: float, velocity_error: float) -> bool:
        """Return whether both errors are within the tolerance.

        An error of NaN is outside the tolerance.
        """
        return (self.position <= 0.0 or abs(position_error) <= self.position) and (
            self.velocity <= 0.0 or abs(velocity_error) <= self.velocity
        )


ToleranceOverride = Tolerance | float
"""Tolerance of a goal: > 0 replaces the default, < 0 disables the check, and 0 keeps
the default.

A plain number is a position tolerance.
"""


class GoalStarted(Struct, frozen=True, kw_only=True):
    """A goal that a controller has accepted."""

    goal: int
    """Number of the goal."""
    controller: str


class CancelGoal(Request[None], frozen=True):
    """Cancel a goal, as in ROS: the motion decelerates, and the goal is PREEMPTED."""

    goal: int


class ReadGoal(Request[GoalStatus], frozen=True):
    """Read the status of a goal."""

    goal: int
