"""Goals, their tolerances and their outcomes.

A fault is an exception, an outcome is a value.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final

from tool0.protocol.goals import Tolerance, ToleranceOverride

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


UNCHECKED = Tolerance()


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class JointTolerances:
    """Of one joint: on the path, and at the goal."""

    path: Tolerance = UNCHECKED
    goal: Tolerance = UNCHECKED


NO_TOLERANCES = JointTolerances()


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
