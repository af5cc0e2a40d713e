"""The tolerances of goals: a controller's own, and those that a goal overrides."""

from __future__ import annotations

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
"""Largest distance from the end for a prismatic joint [m]."""


UNCHECKED = Tolerance()


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class JointTolerances:
    """Tolerances of one joint: on the path, and at the goal."""

    path: Tolerance = UNCHECKED
    goal: Tolerance = UNCHECKED


NO_TOLERANCES = JointTolerances()


def as_tolerance(override: ToleranceOverride) -> Tolerance:
    """Return a goal's own tolerance with a number for each error."""
    return override if isinstance(override, Tolerance) else Tolerance(override)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class TrajectoryTolerances:
    """The tolerances of a controller, from its ``constraints``."""

    joints: Mapping[str, JointTolerances] = field(default_factory=dict)
    goal_time: float = DEFAULT_GOAL_TIME
    """Time to arrive after the last point [s]; inf is unlimited."""

    def of(self, joint: str) -> JointTolerances:
        """Return the tolerances of one joint."""
        return self.joints.get(joint, NO_TOLERANCES)
