"""The motion of several joints in the tick: sampling, and the check of a goal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import neg, sub
from typing import final

from tool0.control.goal import Goal, GoalResult, GoalStatus
from tool0.control.spline import (
    JointSpline,
    Polynomial,
    Sample,
    Segment,
    SplineSection,
    resting,
)
from tool0.errors import ControlError


@final
class TrajectorySampler:
    """Splines with a cursor: ``advance`` at a change, ``errors`` in every tick."""

    __slots__ = (
        "_moving",
        "_polynomials",
        "_rest",
        "_zeros",
        "arrived",
        "current",
        "next_change",
        "splines",
    )

    def __init__(self, splines: Sequence[JointSpline], time: float) -> None:
        self.splines = tuple(splines)
        self.advance(time)

    def advance(self, time: float) -> None:
        """Find the segments that are active at ``time``, and when that changes."""
        self.current: list[tuple[SplineSection, Segment]] = []
        """The active segment of each joint, and its section."""
        self.arrived: list[bool] = []
        """Whether the joint is at the end of its last segment."""
        self.next_change = math.inf
        """When to call ``advance`` again [s]."""
        polynomials: list[Polynomial] = []
        for spline in self.splines:
            section, segment, following = spline.active(time)
            polynomial, change = _polynomial_at(segment, time)
            polynomials.append(polynomial)
            self.current.append((section, segment))
            is_last = following == math.inf
            self.arrived.append(is_last and time >= segment.end)
            self.next_change = min(self.next_change, change, following)
        self._polynomials = list(enumerate(polynomials))
        self._moving = any(polynomial[2:] != _STILL for polynomial in polynomials)
        self._rest = [polynomial[1] for polynomial in polynomials]
        self._zeros = [0.0] * len(polynomials)

    def errors(
        self, time: float, positions: Sequence[float], velocities: Sequence[float]
    ) -> tuple[list[float], list[float]]:
        """Return desired minus measured positions, and the same of velocities."""
        if not self._moving:
            return list(map(sub, self._rest, positions)), list(map(neg, velocities))
        errors: list[float] = []
        rates: list[float] = []
        for k, (t0, c0, c1, c2, c3, c4, c5, d2, d3, d4, d5) in self._polynomials:
            t = time - t0
            position = c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5))))
            errors.append(position - positions[k])
            velocity = c1 + t * (d2 + t * (d3 + t * (d4 + t * d5)))
            rates.append(velocity - velocities[k])
        return errors, rates

    def desired(self, time: float) -> tuple[list[float], list[float]]:
        """Return the desired positions and velocities."""
        return self.errors(time, self._zeros, self._zeros)

    def samples(self, time: float) -> list[Sample]:
        """Return the desired motion of every joint at any known time."""
        earliest = max(spline.begin for spline in self.splines)
        if not time >= earliest:
            raise ControlError(
                f"no trajectory is known for {time} s, the oldest starts at {earliest}"
            )
        return [spline.sample(time) for spline in self.splines]


_STILL = resting(0.0)[2:]


def _polynomial_at(segment: Segment, time: float) -> tuple[Polynomial, float]:
    """Return the polynomial for ``time``, and until when it holds."""
    if time < segment.start:
        return resting(segment.coefficients[0]), segment.start
    if time < segment.end:
        return segment.polynomial, segment.end
    if time == segment.end:
        return segment.polynomial, math.nextafter(time, math.inf)
    return segment.rest, math.inf


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
        """Check the sampler's joints; ``goal_time`` [s] is grace after the end."""
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
        """Return how the goal ends by the errors at ``time``; None if it continues."""
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
