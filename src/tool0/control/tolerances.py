"""The tolerances of goals: defaults of a controller, and overrides in a goal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final

from tool0.protocol.goals import Tolerance, ToleranceOverride

DEFAULT_GOAL_TIME = 1.0
"""Time to arrive after the last point if ``constraints/goal_time`` is missing [s].

Without ``constraints/goal_time``, ROS uses a time of 0.  Many goals are aborted in ROS
although the joints have arrived, because the velocity is not yet below
``stopped_velocity_tolerance`` in the cycle in which the motion ends.
"""

DEFAULT_STOPPED_VELOCITY = 0.01
"""Value of ``constraints/stopped_velocity_tolerance`` if the YAML does not contain the
parameter [rad/s].  ROS has the same default."""


DEFAULT_GOAL_TOLERANCE = 0.1
"""Goal tolerance if neither the YAML nor the goal specifies a tolerance [rad].  The
value is the tolerance of the controllers in ur_gazebo.

Without a goal tolerance, ROS performs no check, and reports success regardless of the
joint positions.
"""

DEFAULT_SLIDING_TOLERANCE = 0.01
"""Default goal tolerance of a prismatic joint [m]."""


UNCHECKED = Tolerance()


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class JointTolerances:
    """Tolerances of one joint, on the path and at the goal."""

    path: Tolerance = UNCHECKED
    goal: Tolerance = UNCHECKED


NO_TOLERANCES = JointTolerances()


def as_tolerance(override: ToleranceOverride) -> Tolerance:
    """Return the tolerance in a goal as a ``Tolerance``."""
    return override if isinstance(override, Tolerance) else Tolerance(override)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class TrajectoryTolerances:
    """The tolerances of a controller, from its ``constraints``."""

    joints: Mapping[str, JointTolerances] = field(default_factory=dict)
    goal_time: float = DEFAULT_GOAL_TIME
    """Time to arrive after the last point [s]; inf if the time is unlimited."""

    def of(self, joint: str) -> JointTolerances:
        """Return the tolerances of one joint."""
        return self.joints.get(joint, NO_TOLERANCES)
