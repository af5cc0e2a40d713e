"""Postures with which an arm reaches a pose, and the branches they belong to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Literal, final

from tool0.errors import ControlError


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Branch:
    """One of the eight branches of inverse kinematics.

    A field that is None matches both values.  The usual posture of a UR is left, up and
    no flip.  The arm is singular where two branches meet.
    """

    shoulder: Literal["left", "right"] | None = None
    """Side of the upper arm, relative to the line from the base to the wrist center,
    seen from behind the base."""
    elbow: Literal["up", "down"] | None = None
    """Whether the elbow is above the line from the shoulder to the fourth joint.  The
    meaning is reversed when the fourth joint and the wrist center are on different
    sides of the base's axis.  Therefore the value changes only in singular postures."""
    wrist: Literal["flip", "no_flip"] | None = None
    """Sign of the sine of the fifth joint's angle: negative for "no_flip", positive for
    "flip".  The sine is 0 where the sixth axis is parallel to the second axis."""

    def __post_init__(self) -> None:
        for name, values in _BRANCHES.items():
            value = getattr(self, name)
            if value is not None and value not in values:
                raise ControlError(
                    f"{name} must be {values[0]!r} or {values[1]!r}, got {value!r}"
                )

    def includes(self, other: Branch) -> bool:
        """Return whether ``other`` matches each field that is not None."""
        return all(
            getattr(self, name) in (None, getattr(other, name)) for name in _BRANCHES
        )

    def __str__(self) -> str:
        """Return the fields that are not None as text."""
        words = (getattr(self, item.name) for item in fields(self))
        return ", ".join(word for word in words if word is not None) or "any"


_BRANCHES = {
    "shoulder": ("left", "right"),
    "elbow": ("up", "down"),
    "wrist": ("flip", "no_flip"),
}


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Solution:
    """A posture with which an arm reaches a pose."""

    positions: Mapping[str, float]
    """Positions by joint name [rad], ordered from base to tip."""
    branch: Branch
    """Branch of the posture.  No field of the branch is None."""
    distance: float
    """Distance from the posture ``near`` [s].  Each joint's rotation is divided by the
    joint's largest velocity; the distance is the root of the sum of squares of these
    quotients."""
