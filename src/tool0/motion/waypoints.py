"""Smooth motions of joints through waypoints, with blends that cut the corners."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple, final

import numpy as np

from tool0.description.model import Joint
from tool0.kinematics.chain import Array
from tool0.motion.path import Path
from tool0.motion.rules import TIME_TO_FULL_ACCELERATION

_DEVIATION: Final = 3.0 / 16.0
"""Distance of a blend from its corner, divided by the product of the blend's length on
each side and the difference of the two directions."""
_SHARE: Final = 0.5
"""Fraction of the joints' acceleration limits that the curvature of a blend may use.
The remaining fraction is available for speed changes along the blend."""
_GRID: Final = 16
"""Number of intervals per path piece that are used to compute the speed."""
_KNOT: Final = 0.02
"""Time between two knots of the motion [s]."""
_STILL: Final = 1e-9
_LEAST: Final = 1e-8
"""Displacement of each joint if the start and end of a motion coincide [rad | m]."""


@final
class _Piece(NamedTuple):
    """A straight piece of a path, or a blend between two directions."""

    start: Array
    before: Array
    """Direction at the start, as a unit vector."""
    after: Array
    """Direction at the end, as a unit vector."""
    length: float

    def at(self, u: Array) -> tuple[Array, Array, Array]:
        """Return positions and two derivatives along the path, each of shape (n, m).

        The direction changes with a smoothstep function of ``u``, 0 … 1, so the
        curvature is continuous.
        """
        turn = self.after - self.before
        u = u[:, None]
        shape = u**3 - u**4 / 2.0
        q = self.start + self.length * (u * self.before + shape * turn)
        slope = self.before + (3.0 * u**2 - 2.0 * u**3) * turn
        bend = 6.0 * u * (1.0 - u) * turn / self.length
        return q, slope, bend


@final
class SmoothWay:
    """A path through waypoints with blends instead of corners."""

    def __init__(self, poses: Array, deviations: Sequence[float]) -> None:
        """Create the path by cutting the corners.

        Args:
            poses: Waypoints [rad | m], shape (n, n_joints). Consecutive waypoints must
                differ, unless all waypoints are equal. If all waypoints are equal, the
                joints remain at rest.
            deviations: Maximum distance of the path from each corner [rad | m], shape
                (n - 2,). At a corner with distance 0, the motion stops.
        """
        if not np.abs(poses - poses[0]).max() > _STILL:  # the path must have a length
            poses = np.stack([poses[0], poses[0] + _LEAST])
        steps = np.diff(poses, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        directions = steps / lengths[:, None]
        trims = np.zeros(len(poses))
        for k, deviation in enumerate(deviations, 1):
            turn = float(np.linalg.norm(directions[k] - directions[k - 1]))
            room = min(lengths[k - 1], lengths[k]) / 2.0
            wanted = deviation / (_DEVIATION * turn) if turn > _STILL else room
            trims[k] = min(room, wanted)
        self._pieces: list[_Piece] = []
        self._stops: list[int] = []
        """Indices of the pieces before which the motion stops."""
        self._corners: list[int] = []
        """Index of each piece's corner; -1 for straight pieces."""
        for k, (direction, length) in enumerate(zip(directions, lengths, strict=True)):
            rest = length - trims[k] - trims[k + 1]
            if rest > _STILL:
                start = poses[k] + trims[k] * direction
                self._add(_Piece(start, direction, direction, float(rest)), -1)
            if k + 2 == len(poses):
                break
            if trims[k + 1] > _STILL:
                start = poses[k + 1] - trims[k + 1] * direction
                blend = _Piece(start, direction, directions[k + 1], 2.0 * trims[k + 1])
                self._add(blend, k)
            else:
                self._stops.append(len(self._pieces))
        self.end = poses[-1]

    def _add(self, piece: _Piece, corner: int) -> None:
        self._pieces.append(piece)
        self._corners.append(corner)

    def blends(self, n: int) -> Iterator[tuple[int, Array]]:
        """Yield the corner of each blend, and ``n`` + 1 poses along the blend."""
        u = np.linspace(0.0, 1.0, n + 1)
        for piece, corner in zip(self._pieces, self._corners, strict=True):
            if corner >= 0:
                yield corner, piece.at(u)[0]

    def sampled(self) -> tuple[Array, Array, Array, set[int]]:
        """Return a grid of path lengths with both derivatives of the positions.

        The last value of the result contains the grid indices at which the motion is at
        rest.
        """
        u = np.linspace(0.0, 1.0, _GRID + 1)
        ways, rows, begun, rests = [np.zeros(1)], [], 0.0, {0}
        for k, piece in enumerate(self._pieces):
            if k in self._stops:
                rests.add(k * _GRID)
            ways.append(begun + u[1:] * piece.length)
            begun += piece.length
            rows.append([values[:-1] for values in piece.at(u)])
        rows.append([values[-1:] for values in self._pieces[-1].at(u)])
        s = np.concatenate(ways)
        _, slope, bend = (np.concatenate(parts) for parts in zip(*rows, strict=True))
        return s, slope, bend, rests | {len(s) - 1}

    def at(self, s: Array) -> tuple[Array, Array, Array]:
        """Return positions and their derivatives at distances along the path."""
        starts = np.cumsum([0.0, *(piece.length for piece in self._pieces)])
        number = np.searchsorted(starts, s, side="right") - 1
        number = np.clip(number, 0, len(self._pieces) - 1)
        shape = (len(s), len(self.end))
        q, slope, bend = np.empty(shape), np.empty(shape), np.empty(shape)
        for k in sorted(set(number.tolist())):
            here = number == k
            u = (s[here] - starts[k]) / self._pieces[k].length
            q[here], slope[here], bend[here] = self._pieces[k].at(np.clip(u, 0.0, 1.0))
        return q, slope, bend


def time_way(joints: Sequence[Joint], way: SmoothWay, *, speed: float) -> Path:
    """Return a fast motion along a path, from rest to rest.

    The curvature and the changes of speed each use a fraction of the acceleration
    limits. The fastest motion is smoothed over ``TIME_TO_FULL_ACCELERATION``. The
    complete motion is slowed down if a joint would exceed its velocity, acceleration or
    jerk limit.

    Args:
        joints: Joints of the positions, with their limits.
        way: Path of the joints.
        speed: Fraction of each joint's maximum velocity.
    """
    fastest = speed * np.array([joint.max_velocity for joint in joints])
    strongest = np.array([joint.max_acceleration for joint in joints])
    s, slope, bend, rests = way.sampled()
    times, speeds = _profile(s, _Limits(slope, bend, fastest, strongest), rests)
    duration = float(times[-1]) + TIME_TO_FULL_ACCELERATION
    n = max(int(np.ceil(duration / _KNOT)), 4)
    knots = np.linspace(0.0, duration, n + 1)
    x, v, a = _smoothed(times, s, speeds, knots)
    q, slope, bend = way.at(x)
    qd = slope * v[:, None]
    qdd = slope * a[:, None] + bend * v[:, None] ** 2
    q[-1] = way.end
    qd[0] = qd[-1] = qdd[0] = qdd[-1] = 0.0
    jerk = np.diff(qdd, axis=0) / (knots[1] - knots[0])
    jerks = np.array(
        [
            min(joint.max_acceleration / TIME_TO_FULL_ACCELERATION, joint.limits.jerk)
            for joint in joints
        ]
    )
    slower = max(
        1.0,
        float((np.abs(qd) / fastest).max()),
        float((np.abs(qdd) / strongest).max()) ** (1 / 2),
        float((np.abs(jerk) / jerks).max()) ** (1 / 3),
    )
    return Path(
        joint_names=tuple(joint.name for joint in joints),
        times=slower * knots,
        positions=q,
        velocities=qd / slower,
        accelerations=qdd / slower**2,
    )


class _Limits(NamedTuple):
    """Derivatives and joint limits that bound the speed at each point of a grid."""

    slope: Array
    """First derivative of the positions along the path, shape (n, n_joints)."""
    bend: Array
    """Second derivative of the positions along the path, shape (n, n_joints)."""
    fastest: Array
    """Maximum velocities of the joints [rad/s | m/s], shape (n_joints,)."""
    strongest: Array
    """Maximum accelerations of the joints [rad/s² | m/s²], shape (n_joints,)."""


def _profile(s: Array, limits: _Limits, rests: set[int]) -> tuple[Array, Array]:
    """Return the time and speed at each point of a grid."""
    slope, bend, fastest, strongest = limits
    curved = np.abs(bend).max(axis=1) > _STILL
    share = np.where(curved, _SHARE, 1.0)[:, None]
    with np.errstate(divide="ignore"):
        by_speed = (fastest / np.abs(slope)).min(axis=1)
        by_bend = np.sqrt((_SHARE * strongest / np.abs(bend)).min(axis=1))
        ramps = (share * strongest / np.abs(slope)).min(axis=1)
    squares = (np.minimum(by_speed, by_bend) ** 2).tolist()
    for k in rests:
        squares[k] = 0.0
    steps, ramp = np.diff(s).tolist(), ramps.tolist()
    for k in range(len(steps)):
        gain = 2.0 * min(ramp[k], ramp[k + 1]) * steps[k]
        squares[k + 1] = min(squares[k + 1], squares[k] + gain)
    for k in reversed(range(len(steps))):
        gain = 2.0 * min(ramp[k], ramp[k + 1]) * steps[k]
        squares[k] = min(squares[k], squares[k + 1] + gain)
    speeds = np.sqrt(squares)
    durations = 2.0 * np.diff(s) / (speeds[1:] + speeds[:-1])
    return np.concatenate([np.zeros(1), np.cumsum(durations)]), speeds


def _smoothed(
    times: Array, s: Array, speeds: Array, at: Array
) -> tuple[Array, Array, Array]:
    """Return distance, speed and acceleration of the mean of delayed profiles.

    The delays are 0 … ``TIME_TO_FULL_ACCELERATION``. The acceleration is constant
    between consecutive ``times``.
    """
    window = TIME_TO_FULL_ACCELERATION
    h = np.diff(times)
    accelerations = np.diff(speeds) / h
    areas = h * (s[:-1] + h * (speeds[:-1] / 2.0 + h * accelerations / 6.0))
    sums = np.concatenate([np.zeros(1), np.cumsum(areas)])

    def values(t: Array) -> tuple[Array, Array, Array]:
        """Return the integral of the distance, the distance itself and the speed."""
        inside = np.clip(t, 0.0, times[-1])
        k = np.clip(np.searchsorted(times, inside, side="right") - 1, 0, len(h) - 1)
        u = inside - times[k]
        place = s[k] + u * (speeds[k] + u * accelerations[k] / 2.0)
        area = sums[k] + u * (s[k] + u * (speeds[k] / 2.0 + u * accelerations[k] / 6.0))
        late = np.maximum(t - times[-1], 0.0)
        speed = np.where(late > 0.0, 0.0, speeds[k] + u * accelerations[k])
        return area + late * s[-1], place, np.where(t < 0.0, 0.0, speed)

    now, past = values(at), values(at - window)
    x, v, a = ((one - other) / window for one, other in zip(now, past, strict=True))
    return np.clip(x, 0.0, s[-1]), np.maximum(v, 0.0), a
