"""Goals, their tolerances and their outcomes.

A fault is an exception, an outcome is a value.
"""

from __future__ import annotations

import enum
import math
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, final


class GoalStatus(enum.Enum):
    """The status of a goal, as in actionlib."""

    ACTIVE = "ACTIVE"
    SUCCEEDED = "SUCCEEDED"
    ABORTED = "ABORTED"
    PREEMPTED = "PREEMPTED"

    def __repr__(self) -> str:
        """Return the bare name, as ROS prints it."""
        return self.value

    @property
    def is_terminal(self) -> bool:
        """Whether the goal has ended."""
        return self is not GoalStatus.ACTIVE


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class GoalResult:
    """How a trajectory goal ended: control_msgs/FollowJointTrajectoryResult."""

    INVALID_GOAL = -1
    PATH_TOLERANCE_VIOLATED = -4
    GOAL_TOLERANCE_VIOLATED = -5

    status: GoalStatus
    """SUCCEEDED, ABORTED or PREEMPTED."""
    error_code: int = 0
    """0, or ROS's code of what went wrong, such as ``PATH_TOLERANCE_VIOLATED``."""
    error_string: str = ""
    """What went wrong: which joint, by how much."""

    @property
    def is_violation(self) -> bool:
        """Whether a tolerance was violated."""
        codes = self.PATH_TOLERANCE_VIOLATED, self.GOAL_TOLERANCE_VIOLATED
        return self.error_code in codes


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class GripperResult:
    """How a gripper goal ended: control_msgs/GripperCommandResult, joint units."""

    status: GoalStatus
    """SUCCEEDED, ABORTED or PREEMPTED."""
    position: float
    """Of the driven joint [rad | m]."""
    effort: float
    """That the drive exerts [N·m | N]."""
    stalled: bool
    """Whether the joint stood still before it arrived."""
    reached_goal: bool
    """Whether the joint arrived within the goal tolerance."""
    holds: bool = False
    """Whether something presses on both fingers: what stopped the joint is held."""
    error_string: str = ""
    """What stopped the joint before it arrived; empty if it arrived."""


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
        self.explain: Callable[[Result], Result] = lambda result: result
        """Adds to the outcome what the controller does not know, such as contacts."""

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
            self._result = self.explain(result)
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


DEFAULT_GOAL_TIME = 1.0
"""Grace after the last point [s] where YAML has no ``constraints/goal_time``.

ROS uses 0 there, and then aborts many goals that have arrived, because the velocity is
not yet below ``stopped_velocity_tolerance`` in the very cycle in which the motion ends.
"""

DEFAULT_STOPPED_VELOCITY = 0.01
"""``constraints/stopped_velocity_tolerance`` where YAML has none [rad/s], as in ROS."""


DEFAULT_GOAL_TOLERANCE = 0.1
"""Largest distance from the end of a trajectory [rad] where neither YAML nor the goal
has one: that of ur_gazebo's controllers.

ROS checks nothing there, and reports that a goal has succeeded wherever its joints are.
"""

DEFAULT_SLIDING_TOLERANCE = 0.01
"""The same for a prismatic joint [m]."""


class Tolerance(NamedTuple):
    """Largest allowed errors of one joint; 0 is not checked."""

    position: float = 0.0
    """[rad | m]"""
    velocity: float = 0.0
    """[rad/s | m/s]"""
    acceleration: float = 0.0
    """Never violated: no acceleration is measured, in ROS as here."""

    def allows(self, position_error: float, velocity_error: float) -> bool:
        """Return whether both errors are within; NaN is not."""
        return (self.position <= 0.0 or abs(position_error) <= self.position) and (
            self.velocity <= 0.0 or abs(velocity_error) <= self.velocity
        )


UNCHECKED = Tolerance()


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class JointTolerances:
    """Of one joint: on the path, and at the goal."""

    path: Tolerance = UNCHECKED
    goal: Tolerance = UNCHECKED


NO_TOLERANCES = JointTolerances()

ToleranceOverride = Tolerance | float
"""A goal's own tolerance: > 0 replaces, < 0 switches off, 0 keeps the default.

A plain number is the position's.
"""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class TrajectoryTolerances:
    """The tolerances of a controller, from its ``constraints``."""

    joints: Mapping[str, JointTolerances] = field(default_factory=dict)
    goal_time: float = DEFAULT_GOAL_TIME
    """Time that a joint may take to arrive after its last point [s]."""

    def of(
        self,
        joint: str,
        path: ToleranceOverride | None,
        goal: ToleranceOverride | None,
    ) -> JointTolerances:
        """Return the joint's tolerances, overridden by those of the goal."""
        default = self.joints.get(joint, NO_TOLERANCES)
        if path is None and goal is None:
            return default
        return JointTolerances(
            path=_override(default.path, path), goal=_override(default.goal, goal)
        )

    def goal_time_with(self, override: float | None) -> float:
        """Return the grace [s] for a goal with its own ``goal_time_tolerance``.

        As for tolerances: > 0 replaces, 0 keeps; < 0 means no limit, so that the goal
        waits until it arrives (ROS would take that for no grace at all).
        """
        if override is None or override == 0.0:
            return self.goal_time
        return override if override > 0.0 else math.inf


def _override(default: Tolerance, override: ToleranceOverride | None) -> Tolerance:
    if override is None:
        return default
    wanted = override if isinstance(override, Tolerance) else Tolerance(override)
    pairs = zip(default, wanted, strict=True)
    return Tolerance(*(max(new, 0.0) if new else old for old, new in pairs))
