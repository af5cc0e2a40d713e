"""Motions of Universal Robots' arms: movej, movel, movep, movec and their blends.

The rules are those of the URScript manual (e-Series 5.x; CB3 3.x has the same ones):

* movej moves all joints synchronously; ``a`` and ``v`` apply to the joint that turns
  most.  The others move the tool on a line or an arc; ``a`` and ``v`` apply to the TCP.
  On a line, the tool turns at no more than 4 rad/s per m/s of ``v``, and likewise for
  ``a``; the slower of translation and rotation sets the pace
  (https://forum.universal-robots.com/t/movel-tool-angular-speed/15912).
* Speed is a trapezoid over time, or a triangle.  A time ``t`` replaces ``a`` and ``v``;
  the manual does not say how; here each ramp from or to rest takes a quarter of ``t``.
* A move with a radius ``r`` ends where the tool comes within ``r`` of its target, and
  the next move is entered no farther away than that.  The speed at which the blend
  begins does not depend on the next move, so the arm can still stop at the target; it
  does if there is no next move.
* Between two movej the blend is a smooth curve of the joints, otherwise of the tool;
  between two movep it is an arc at constant speed.
* If blends overlap, UR skips the waypoint with a warning; here both become smaller,
  also with a warning.
* Where a joint would be too fast, the whole move is slower than requested.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, final

from tool0.description.transform_arrays import rotation_vector
from tool0.errors import ControlError, UnreachableError
from tool0.kinematics.chain import Array
from tool0.motion.blend import TURN_RATIO
from tool0.motion.path import Path
from tool0.motion.profile import SpeedProfile, braking
from tool0.motion.segments import PathSegment

MoveKind = Literal["joint", "linear", "process", "circular", "servo_circular"]
FUNCTIONS: dict[MoveKind, str] = {
    "joint": "movej",
    "linear": "movel",
    "process": "movep",
    "circular": "movec",
    "servo_circular": "servoc",
}
"""The functions of URScript."""
WarningKind = Literal["blend", "stop", "speed"]
"""Deviations: a smaller blend, a stop instead of a blend, a lower speed."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Move:
    """One motion; poses of the TCP are p[x, y, z, rx, ry, rz] in any one frame."""

    kind: MoveKind
    q: Sequence[float] | None = None
    """Target positions of the joints [rad]; give either these or a pose."""
    pose: Sequence[float] | None = None
    """Target pose."""
    via: Sequence[float] | None = None
    """Pose through which an arc passes; only its position is used."""
    a: float
    """Acceleration of the leading joint [rad/s²], or of the TCP [m/s²]."""
    v: float
    """Speed of the leading joint [rad/s], or of the TCP [m/s]."""
    t: float = 0.0
    """Duration [s]; if above 0, it replaces ``a`` and ``v``."""
    r: float = 0.0
    """Blend radius [m]."""
    w: float | None = None
    """Angular speed of the tool on a line [rad/s]; TURN_RATIO times ``v`` if left
    out."""
    mode: int = 0
    """Orientation on an arc.  0: interpolated to the target's orientation; 1: at a
    constant angle to the arc, ignoring the target's orientation."""

    def __post_init__(self) -> None:
        if (self.q is None) == (self.pose is None):
            raise ControlError(f"{self} needs joint positions or a pose, one of them")
        if (self.kind == "circular") != (self.via is not None):
            raise ControlError("an arc needs a via pose; other moves must not have one")
        if self.mode not in {0, 1}:
            raise ControlError(f"{self}: mode must be 0 or 1, got {self.mode}")
        if not 0.0 <= self.t < math.inf or not 0.0 <= self.r < math.inf:
            raise ControlError(f"{self}: t and r must be at least 0 and finite")
        if self.t == 0.0 and not (0.0 < self.a < math.inf and 0.0 < self.v < math.inf):
            raise ControlError(
                f"{self}: acceleration and speed must be above 0 and finite, got "
                f"a={self.a}, v={self.v}"
            )
        if self.w is not None and not 0.0 < self.w < math.inf:
            raise ControlError(f"{self}: w must be above 0 and finite, got {self.w}")
        for values in (self.q, self.pose, self.via):
            if values is not None and (
                len(values) != 6 or not all(math.isfinite(x) for x in values)
            ):
                raise ControlError(f"{self} needs six finite numbers, got {values}")

    @property
    def turn_ratio(self) -> float:
        """Angular speed of the tool on a line per linear speed [rad/m]."""
        return TURN_RATIO if self.w is None else self.w / self.v

    def __str__(self) -> str:
        """Return the name of the URScript function."""
        return FUNCTIONS[self.kind]


def pose_numbers(T: Array) -> tuple[float, ...]:
    """Return a pose, shape (4, 4), in the form of moves: p[x, y, z, rx, ry, rz]."""
    return (*T[:3, 3].tolist(), *rotation_vector(T[:3, :3]).tolist())


@final
class MoveError(UnreachableError):
    """A move in a sequence that cannot be executed."""

    def __init__(self, number: int, move: Move, reason: object) -> None:
        super().__init__(f"move {number} ({move}): {reason}")
        self.number = number
        """Number of the move in the sequence, from 1 on."""
        self.reason = str(reason)


class MoveWarning(NamedTuple):
    """Deviation of a move in a sequence from the request."""

    number: int
    """Number of the move in the sequence, from 1 on."""
    move: Move
    kind: WarningKind
    text: str

    def __str__(self) -> str:
        """Return the message with the move's number and its URScript function."""
        return f"move {self.number} ({self.move}): {self.text}"


class Tail(NamedTuple):
    """The end of a plan, within the blend radius of its last target."""

    segment: PathSegment
    kind: MoveKind
    radius: float
    """Radius around the last target [m]."""
    remaining: float
    """Distance to the target, in units of the segment's x."""
    speed: float
    acceleration: float
    """Acceleration of the move."""
    T_tip_tool: Array
    """Pose of the tool in the flange, shape (4, 4)."""
    entry: float
    """Path time at which the tool comes within the radius [s]."""

    @property
    def brake(self) -> SpeedProfile:
        """Profile that brings the tool to rest at the target."""
        return braking(self.remaining, self.speed, self.acceleration)


@final
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MovePlan:
    """The path through a sequence of moves."""

    path: Path
    """Joint positions over time, as cubics."""
    begins: tuple[float, ...]
    """Path time at which each move begins, with the blend into it [s]."""
    zones: tuple[float, ...]
    """Path time at which each move comes within its blend radius, or ends [s]."""
    warnings: tuple[MoveWarning, ...]
    tail: Tail | None
    """End of the path, within the blend radius of the last move, from which it can
    blend into another move; None without a radius."""

    @property
    def duration(self) -> float:
        """Duration of the whole motion [s]."""
        return self.path.duration

    @property
    def end(self) -> Array:
        """Joint positions at the end, at rest [rad], shape (6,)."""
        return self.path.end

    def move_at(self, time: float) -> int:
        """Return the index of the move at a path time."""
        return max(sum(begin <= time for begin in self.begins) - 1, 0)
