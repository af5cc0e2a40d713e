"""Desired motions of many joints, as sequences of cubics."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from tool0.control.spline import IMPLAUSIBLE, wrap_offset

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class JointGoal(NamedTuple):
    """A joint that is moved by a command on the device."""

    source: int
    """Column of the joint in the command array."""
    joint: int
    """Number of the joint in its controller."""
    lower: float
    upper: float
    """Position limits of the joint [rad | m]."""


@final
class Motions:
    """Motions of k joints of n robots, divided into pieces.

    The motions are lines or cubics, followed by rest.  The motions are equal to those
    of a JointTrajectoryController that receives points without accelerations on its
    topic.
    """

    def __init__(self, position: Array, wraps: Sequence[bool]) -> None:
        """Start with every joint at rest at ``position`` [rad | m], shape (n, k).

        The elements of ``wraps`` are true for continuous joints.
        """
        self._wraps = tuple(wraps)
        self.until: Array = np.full((*position.shape, 1), math.inf)
        """End of each piece [s], at which the next piece starts, shape (n, k,
        n_pieces)."""
        self.origin: Array = np.zeros_like(self.until)
        """Start of each piece [s], shape (n, k, n_pieces)."""
        self.coefficients: Array = np.zeros((*self.until.shape, 4))
        """Coefficients of each piece's polynomial in the time since ``origin``, in
        order of increasing power, shape (n, k, n_pieces, 4)."""
        self.coefficients[..., 0, 0] = position

    def rest(self, rows: Indices, position: Array) -> None:
        """Set the joints of some robots to rest at ``position``, (len(rows), k)."""
        self.until[rows] = math.inf
        self.coefficients[rows] = 0.0
        self.coefficients[rows, :, 0, 0] = position

    def desired(self, rows: Indices, joint: int, now: Array) -> tuple[Array, Array]:
        """Return the desired positions and velocities of a joint, each (len(rows),)."""
        piece = (now[:, None] >= self.until[rows, joint]).sum(axis=1)
        c = np.moveaxis(self.coefficients[rows, joint, piece], -1, 0)
        t = now - self.origin[rows, joint, piece]
        position = c[0] + t * (c[1] + t * (c[2] + t * c[3]))
        return position, c[1] + t * (2.0 * c[2] + t * 3.0 * c[3])

    def start(
        self,
        rows: Indices,
        joints: Sequence[int],
        *,
        now: Array,
        times: Array,
        positions: Array,
        velocities: Array | None,
    ) -> int | None:
        """Start motions from the current desired motion through m points to rest.

        Args:
            rows: The r robots.
            joints: The j joints that move.
            now: The time of the next tick [s], shape (r,).
            times: Times of the points relative to ``now`` [s], in increasing order,
                shape (r, m).
            positions: Positions of the points [rad | m], shape (r, m, j).
            velocities: Velocities at the points [rad/s | m/s], shape (r, m, j).  If
                ``velocities`` is None, the motions between the points are linear.

        Returns:
            None, or the number of a row that requests an implausible motion.  If a row
            is returned, no motion has been changed.
        """
        n_points = times.shape[1]
        ends = now[:, None] + times
        begins = np.concatenate([now[:, None], ends[:, :-1]], axis=1)
        found = np.zeros((len(rows), len(joints), n_points, 4))
        for j, joint in enumerate(joints):
            q, qd = self.desired(rows, joint, now)
            target = positions[:, :, j]
            if self._wraps[joint]:
                pairs = zip(q.tolist(), target[:, 0].tolist(), strict=True)
                target = target + np.array([[wrap_offset(a, b)] for a, b in pairs])
            for m in range(n_points):
                T, end = ends[:, m] - begins[:, m], target[:, m]
                speed = None if velocities is None else velocities[:, m, j]
                found[:, j, m] = _fit(q, qd, end, speed, T)
                q, qd = end, qd if speed is None else speed
        T = (ends - begins)[:, None]
        is_bounded = _largest(found, T) <= IMPLAUSIBLE
        if not is_bounded.all():
            return int(np.argwhere(~is_bounded)[0, 0])
        self.extend(n_points + 1)
        columns = np.array(joints, dtype=np.intp)
        at = np.ix_(rows, columns, np.arange(n_points))
        c = np.moveaxis(found[:, :, -1], -1, 0)
        t = T[..., -1]
        rest = np.zeros((len(rows), len(joints), 4))
        rest[..., 0] = c[0] + t * (c[1] + t * (c[2] + t * c[3]))
        chosen = np.ix_(rows, columns)
        self.until[chosen] = math.inf
        self.until[at] = ends[:, None]
        # At the end time, the motion is still active.
        last = np.nextafter(ends[:, -1:], math.inf)
        self.until[(*chosen, n_points - 1)] = last
        self.origin[at] = begins[:, None]
        self.coefficients[at] = found
        self.coefficients[(*chosen, n_points)] = rest
        return None

    def extend(self, n_pieces: int) -> None:
        """Allocate memory for ``n_pieces`` pieces of each motion."""
        missing = n_pieces - self.until.shape[2]
        if missing > 0:
            room = ((0, 0), (0, 0), (0, missing))
            self.until = np.pad(self.until, room, constant_values=math.inf)
            self.origin = np.pad(self.origin, room)
            self.coefficients = np.pad(self.coefficients, (*room, (0, 0)))


def _fit(q0: Array, v0: Array, q1: Array, v1: Array | None, T: Array) -> Array:
    """Return the coefficients of ``control.spline.Segment``, shape (…, 4)."""
    zeros = np.zeros_like(q0)
    if v1 is None:
        return np.stack([q0, (q1 - q0) / T, zeros, zeros], axis=-1)
    d = q1 - q0
    c2 = (3.0 * d - (2.0 * v0 + v1) * T) / T / T
    c3 = (-2.0 * d + (v0 + v1) * T) / T / T / T
    return np.stack([q0, v0, c2, c3], axis=-1)


def _largest(coefficients: Array, T: Array) -> Array:
    """Return bounds of position and velocity, as ``Segment.is_bounded`` does."""
    a = np.moveaxis(np.abs(coefficients), -1, 0)
    position = a[0] + T * (a[1] + T * (a[2] + T * a[3]))
    speed = a[1] + T * (2.0 * a[2] + T * 3.0 * a[3])
    return np.asarray(np.maximum(position, speed))
