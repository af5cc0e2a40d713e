"""Motions of Universal Robots' arms: movej, movel, movep, movec and their blends.

The rules follow the URScript manual (e-Series 5.x; the rules of CB3 3.x are the same):

* movej moves all joints synchronously; ``a`` and ``v`` are the limits of the joint that
  turns most. The other functions move the tool along a line or an arc; ``a`` and ``v``
  are the limits of the TCP. Along a line, the angular speed of the tool is at most 4
  rad/s per m/s of ``v``, and its angular acceleration is at most 4 rad/s² per m/s² of
  ``a``. The slower of translation and rotation determines the duration
  (https://forum.universal-robots.com/t/movel-tool-angular-speed/15912).
* The speed is a trapezoid or a triangle over time. A time ``t`` replaces ``a`` and
  ``v``. The manual does not specify the profile for ``t``; in tool0, each ramp from
  rest or to rest takes a quarter of ``t``.
* A move with a radius ``r`` ends where the distance of the tool from the move's target
  becomes ``r``. The next move starts at a distance of at most ``r`` from the target of
  the first move. The speed at the start of the blend does not depend on the next move,
  so the arm can still stop at the target. If there is no next move, the arm stops at
  the target.
* Between two movej moves, the blend is a smooth curve of the joints. Between two movep
  moves, the blend is an arc at constant speed. In other cases, the blend is a smooth
  curve of the tool.
* If blends overlap, UR skips the waypoint with a warning. In tool0, overlapping blends
  become smaller, also with a warning.
* If a joint would be too fast, the whole move is slower than requested.
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
"""URScript function of each kind of move."""
WarningKind = Literal["blend", "stop", "speed"]
"""Kinds of deviations: a smaller blend, a stop instead of a blend, a lower speed."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Move:
    """One motion; poses of the TCP are p[x, y, z, rx, ry, rz] in any common frame."""

    kind: MoveKind
    q: Sequence[float] | None = None
    """Target positions of the joints [rad]. Specify either ``q`` or ``pose``."""
    pose: Sequence[float] | None = None
    """Target pose of the TCP."""
    via: Sequence[float] | None = None
    """Pose through which an arc passes; only its position is used."""
    a: float
    """Acceleration of the leading joint [rad/s²], or of the TCP [m/s²]."""
    v: float
    """Speed of the leading joint [rad/s], or of the TCP [m/s]."""
    t: float = 0.0
    """Duration [s]. A duration greater than 0 replaces ``a`` and ``v``."""
    r: float = 0.0
    """Blend radius [m]."""
    w: float | None = None
    """Angular speed of the tool along a line [rad/s]; by default, TURN_RATIO times
    ``v``."""
    mode: int = 0
    """Orientation along an arc. In mode 0, the orientation is interpolated to the
    target's orientation. In mode 1, the orientation keeps a constant angle to the arc,
    and the target's orientation is ignored."""

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
        """Ratio of the tool's angular speed to its linear speed on a line [rad/m]."""
        return TURN_RATIO if self.w is None else self.w / self.v

    def __str__(self) -> str:
        """Return the name of the URScript function."""
        return FUNCTIONS[self.kind]


def pose_numbers(T: Array) -> tuple[float, ...]:
    """Return a pose, shape (4, 4), in the format of moves: p[x, y, z, rx, ry, rz]."""
    return (*T[:3, 3].tolist(), *rotation_vector(T[:3, :3]).tolist())


@final
class MoveError(UnreachableError):
    """Raised if a move in a sequence cannot be executed."""

    def __init__(self, number: int, move: Move, reason: object) -> None:
        super().__init__(f"move {number} ({move}): {reason}")
        self.number = number
        """Number of the move in the sequence, starting at 1."""
        self.reason = str(reason)


class MoveWarning(NamedTuple):
    """Deviation of a move in a sequence from the requested move."""

    number: int
    """Number of the move in the sequence, starting at 1."""
    move: Move
    kind: WarningKind
    text: str

    def __str__(self) -> str:
        """Return the message with the move's number and its URScript function."""
        return f"move {self.number} ({self.move}): {self.text}"


class Tail(NamedTuple):
    """The end of a plan, inside the blend radius around its last target."""

    segment: PathSegment
    kind: MoveKind
    radius: float
    """Radius around the last target [m]."""
    remaining: float
    """Distance from the target, measured as the segment's x [rad | m]."""
    speed: float
    acceleration: float
    """Acceleration along the segment [rad/s² | m/s²]."""
    T_tip_tool: Array
    """Pose of the tool in the flange's frame, shape (4, 4)."""
    entry: float
    """Path time at which the tool enters the radius [s]."""

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
    """Path time at which each move begins, including the blend to this move [s]."""
    zones: tuple[float, ...]
    """Path time at which each move enters its blend radius or ends [s]."""
    warnings: tuple[MoveWarning, ...]
    tail: Tail | None
    """End of the path within the blend radius of the last move, from which the path can
    blend into another move; None if the last move has no radius."""

    @property
    def duration(self) -> float:
        """Duration of the complete motion [s]."""
        return self.path.duration

    @property
    def end(self) -> Array:
        """Joint positions at the end of the path [rad], shape (6,)."""
        return self.path.end

    def move_at(self, time: float) -> int:
        """Return the index of the move that is executed at a path time."""
        return max(sum(begin <= time for begin in self.begins) - 1, 0)
