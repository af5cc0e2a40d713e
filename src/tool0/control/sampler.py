"""Samples the motion of several joints in the tick, and monitors a goal."""

from __future__ import annotations

import copy
import enum
import math
from collections.abc import Collection, Iterable, Sequence
from operator import neg, sub
from typing import NamedTuple, final

from tool0.control.spline import (
    JointSpline,
    Polynomial,
    Sample,
    Segment,
    SplineSection,
    resting,
)
from tool0.control.tolerances import UNCHECKED
from tool0.errors import ControlError
from tool0.protocol.goals import Goal, GoalResult, GoalStatus, Tolerance


class Piece(NamedTuple):
    """Desired motion of one joint until the polynomial changes."""

    until: float
    """Start time of the next piece [s]; inf for the last piece."""
    polynomial: Polynomial
    section: SplineSection
    """The section that contains the piece."""
    segment: Segment
    has_ended: bool
    """Whether the piece is at or after the end of the segment."""
    is_last: bool
    """Whether the segment is the last segment."""

    @property
    def is_at_end(self) -> bool:
        """Whether the entire motion of the joint has ended."""
        return self.has_ended and self.is_last


def piece_at(spline: JointSpline, time: float) -> Piece:
    """Return the piece of a motion that is active at ``time`` [s]."""
    section, segment, following = spline.active(time)
    if time < segment.start:
        polynomial, change = resting(segment.coefficients[0]), segment.start
    elif time < segment.end:
        polynomial, change = segment.polynomial, segment.end
    elif time == segment.end:
        polynomial, change = segment.polynomial, math.nextafter(time, math.inf)
    else:
        polynomial, change = segment.rest, math.inf
    return Piece(
        min(change, following),
        polynomial,
        section,
        segment,
        time >= segment.end,
        following == math.inf,
    )


def pieces_from(spline: JointSpline, time: float, most: int) -> list[Piece]:
    """Return up to ``most`` pieces of a motion, starting at ``time`` [s]."""
    found: list[Piece] = []
    while len(found) < most and time < math.inf:
        found.append(piece_at(spline, time))
        time = found[-1].until
    return found


@final
class TrajectorySampler:
    """Splines with a cursor.

    Call ``errors`` in each tick, and call ``advance`` when a piece changes.
    """

    __slots__ = (
        "_moving",
        "_polynomials",
        "_rest",
        "_zeros",
        "next_change",
        "pieces",
        "splines",
    )

    def __init__(self, splines: Sequence[JointSpline], time: float) -> None:
        self.splines = tuple(splines)
        self.advance(time)

    def __deepcopy__(self, memo: dict[int, object]) -> TrajectorySampler:
        """Return a sampler that shares the splines.

        Only the cursor changes, so the splines need not be copied.
        """
        return copy.copy(self)

    def advance(self, time: float) -> None:
        """Find the pieces that are active at ``time`` [s], and the next change."""
        self.pieces = [piece_at(spline, time) for spline in self.splines]
        """The active piece of each joint."""
        self.next_change = min(piece.until for piece in self.pieces)
        """Time at which ``advance`` has to be called again [s]."""
        polynomials = [piece.polynomial for piece in self.pieces]
        self._polynomials = list(enumerate(polynomials))
        self._moving = any(polynomial[2:] != _STILL for polynomial in polynomials)
        self._rest = [polynomial[1] for polynomial in polynomials]
        self._zeros = [0.0] * len(polynomials)

    def errors(
        self, time: float, positions: Sequence[float], velocities: Sequence[float]
    ) -> tuple[list[float], list[float]]:
        """Return the position errors and velocity errors (desired minus measured)."""
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
        """Return the desired motion of every joint, or raise ControlError.

        ControlError is raised if the motion at ``time`` [s] is unknown.
        """
        earliest = max(spline.begin for spline in self.splines)
        if not time >= earliest:
            raise ControlError(
                f"no trajectory is known for {time} s, the oldest starts at {earliest}"
            )
        return [spline.sample(time) for spline in self.splines]


_STILL = resting(0.0)[2:]


SUCCEEDED = GoalResult(status=GoalStatus.SUCCEEDED)


class Check(enum.IntEnum):
    """The kind of check that an active goal requires for a joint."""

    NOTHING = 0
    PATH = 1
    GOAL = 2


@final
class GoalMonitor:
    """Checks one active goal in every tick.

    If segments of a previous trajectory are still being executed when a goal starts,
    they are not checked.  As in ROS, a joint is considered to have arrived after it has
    been within its goal tolerances once.
    """

    def __init__(
        self, goal: Goal, joint_names: tuple[str, ...], goal_time: float
    ) -> None:
        """Store a goal; ``goal_time`` [s] is the time to arrive after the end."""
        self.goal = goal
        self._joint_names = joint_names
        self.goal_time = goal_time
        """Time that the joints may take to arrive after the end of the trajectory
        [s]."""
        self._arrived: set[int] = set()

    def check_of(self, piece: Piece) -> tuple[Check, Tolerance]:
        """Return the kind of check during a piece, and its tolerance."""
        section = piece.section
        if section.goal is self.goal:
            if piece.is_at_end:
                return Check.GOAL, section.tolerances.goal
            path = section.tolerances.path
            if not piece.has_ended and (path.position > 0.0 or path.velocity > 0.0):
                return Check.PATH, path
        return Check.NOTHING, UNCHECKED

    def watch(self, sampler: TrajectorySampler) -> None:
        """Collect the checks until the next change of the sampler."""
        self._ends = [piece.segment.end for piece in sampler.pieces]
        self._on_path: list[tuple[int, Tolerance]] = []
        self._at_goal: list[tuple[int, Tolerance]] = []
        self._path_limit = math.inf
        self._checks_path_velocity = False
        for k, piece in enumerate(sampler.pieces):
            check, tolerance = self.check_of(piece)
            if check is Check.GOAL and k not in self._arrived:
                self._at_goal.append((k, tolerance))
            elif check is Check.PATH:
                self._on_path.append((k, tolerance))
                limit = tolerance.position or math.inf
                self._path_limit = min(self._path_limit, limit)
                self._checks_path_velocity |= tolerance.velocity > 0.0

    @property
    def arrived(self) -> Collection[int]:
        """Indices of the joints that have been within their goal tolerances."""
        return self._arrived

    def note_arrived(self, joints: Iterable[int]) -> None:
        """Mark additional joints, given by index, as arrived."""
        self._arrived.update(joints)
        self._at_goal = [item for item in self._at_goal if item[0] not in self._arrived]

    def check(
        self, time: float, errors: list[float], rates: list[float]
    ) -> GoalResult | None:
        """Return the result if the goal ends at ``time``; None if it continues."""
        if self._on_path and (
            self._checks_path_velocity or max(map(abs, errors)) > self._path_limit
        ):
            for k, path in self._on_path:
                if not path.allows(errors[k], rates[k]):
                    code = GoalResult.PATH_TOLERANCE_VIOLATED
                    return self._violation(code, "path", k, errors[k])
        return self._check_arrival(time, errors, rates) if self._at_goal else None

    def _check_arrival(
        self, time: float, errors: list[float], rates: list[float]
    ) -> GoalResult | None:
        waiting = []
        for k, tolerance in self._at_goal:
            if tolerance.allows(errors[k], rates[k]):
                self._arrived.add(k)
            elif time < self._ends[k] + self.goal_time:
                waiting.append((k, tolerance))
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
