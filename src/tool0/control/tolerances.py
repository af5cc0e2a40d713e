"""The tolerances of goals: a controller's own ones, and those that a goal overrides."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final

from tool0.protocol.goals import Tolerance, ToleranceOverride

DEFAULT_GOAL_TIME = 1.0
"""Time to arrive after the last point if YAML has no ``constraints/goal_time`` [s].

In this case, ROS uses 0 and then aborts many goals that have arrived, because the
velocity is not yet below ``stopped_velocity_tolerance`` in the very cycle in which the
motion ends.
"""

DEFAULT_STOPPED_VELOCITY = 0.01
"""``constraints/stopped_velocity_tolerance`` if YAML does not have it [rad/s], as in
ROS."""


DEFAULT_GOAL_TOLERANCE = 0.1
"""Goal tolerance if neither YAML nor the goal specifies one [rad]: that of ur_gazebo's
controllers.

In this case, ROS checks nothing, and reports success wherever the joints are.
"""

DEFAULT_SLIDING_TOLERANCE = 0.01
"""Default goal tolerance of a prismatic joint [m]."""


UNCHECKED = Tolerance()


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class JointTolerances:
    """Tolerances of one joint: on the path, and at the goal."""

    path: Tolerance = UNCHECKED
    goal: Tolerance = UNCHECKED


NO_TOLERANCES = JointTolerances()


def as_tolerance(override: ToleranceOverride) -> Tolerance:
    """Return a goal's own tolerance as a ``Tolerance``."""
    return override if isinstance(override, Tolerance) else Tolerance(override)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class TrajectoryTolerances:
    """The tolerances of a controller, from its ``constraints``."""

    joints: Mapping[str, JointTolerances] = field(default_factory=dict)
    goal_time: float = DEFAULT_GOAL_TIME
    """Time to arrive after the last point [s]; inf for unlimited."""

    def of(self, joint: str) -> JointTolerances:
        """Return the tolerances of one joint."""
        return self.joints.get(joint, NO_TOLERANCES)
