"""Tolerances of trajectories: defaults from YAML, and a goal's own."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, final

DEFAULT_GOAL_TIME = 1.0
"""Grace after the last point [s] where YAML has no ``constraints/goal_time``.

ROS takes 0 there, and then aborts many a goal that arrived, because the velocity is not
yet below ``stopped_velocity_tolerance`` in the very cycle in which the motion ends.
"""

DEFAULT_STOPPED_VELOCITY = 0.01
"""``constraints/stopped_velocity_tolerance`` where YAML has none [rad/s], as in ROS."""


class Tolerance(NamedTuple):
    """Largest allowed errors of one joint; 0 is not checked."""

    position: float = 0.0
    velocity: float = 0.0
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
        """Return the joint's tolerances with a goal's own put over them."""
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
    return Tolerance(*map(_override_field, default, wanted))


def _override_field(default: float, override: float) -> float:
    if override > 0.0:
        return override
    return 0.0 if override < 0.0 else default


def tolerance_numbers(override: ToleranceOverride) -> tuple[float, ...]:
    """Return every number of an override, to check them."""
    return tuple(override) if isinstance(override, Tolerance) else (override,)
