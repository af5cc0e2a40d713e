"""The result of planning: joint positions over time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from tool0.kinematics.chain import Array

_QUINTIC = np.array(
    [
        [1, 0, 0, -10, 15, -6],
        [0, 1, 0, -6, 8, -3],
        [0, 0, 0.5, -1.5, 1.5, -0.5],
        [0, 0, 0, 10, -15, 6],
        [0, 0, 0, -4, 7, -3],
        [0, 0, 0, 0.5, -1, 0.5],
    ]
)
"""Quintics over 0 … 1. Each quintic has one end value of 1 and five end values of 0.
The end values are the position, velocity and acceleration at the start, followed by
those at the end. The coefficients are ordered from u⁰ to u⁵."""
_POWERS = np.arange(6)


class Cubics(NamedTuple):
    """Joint positions over time or a path parameter, with cubics between the knots."""

    times: Array
    """Times [s] or values of the path parameter, shape (n,)."""
    q: Array
    """Joint positions [rad], shape (n, n_joints)."""
    qd: Array
    """Joint velocities [rad/s], or derivatives with respect to the path parameter,
    shape (n, n_joints)."""

    def at(self, times: Array) -> Cubics:
        """Return the motion sampled at other times within its duration."""
        k, h, u = _intervals(self.times, times)
        here, there = self.q[k], self.q[k + 1]
        out, into = h * self.qd[k], h * self.qd[k + 1]
        q = (
            (1 + 2 * u) * (1 - u) ** 2 * here
            + u * (1 - u) ** 2 * out
            + u**2 * (3 - 2 * u) * there
            + u**2 * (u - 1) * into
        )
        slope = (
            6 * u * (1 - u) * (there - here)
            + (1 - u) * (1 - 3 * u) * out
            + u * (3 * u - 2) * into
        )
        return Cubics(times, q, slope / h)


@final
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Path:
    """A motion of joints to rest, defined by knots, which every planner returns.

    Consecutive knots are connected by cubics, or by quintics if accelerations are
    specified. Arrays have shape (n_knots, n_joints).
    """

    joint_names: tuple[str, ...]
    times: Array
    """Increasing times of the knots [s], shape (n_knots,). The first time is 0, which
    is the start."""
    positions: Array
    """Joint positions [rad | m]."""
    velocities: Array
    """Joint velocities [rad/s | m/s]."""
    accelerations: Array | None = None
    """Joint accelerations [rad/s² | m/s²]; None for cubics."""

    @property
    def duration(self) -> float:
        """Duration of the motion [s]."""
        return float(self.times[-1])

    @property
    def end(self) -> Array:
        """Positions at the end of the path [rad | m], shape (n_joints,)."""
        return np.asarray(self.positions[-1])

    def at(self, times: Array) -> Path:
        """Return the same motion with knots at ``times`` within its duration [s]."""
        if self.accelerations is None:
            q, qd = Cubics(self.times, self.positions, self.velocities).at(times)[1:]
            return self._at(times, q, qd)
        k, h, u = _intervals(self.times, times)
        values = (self.positions, self.velocities, self.accelerations)
        ends = np.array(
            [h**n * rows[end] for end in (k, k + 1) for n, rows in enumerate(values)]
        )
        found, terms = [], _QUINTIC
        for order in range(3):
            basis = u ** _POWERS[: terms.shape[1]] @ terms.T
            found.append(np.einsum("tb,btj->tj", basis, ends) / h**order)
            terms = terms[:, 1:] * _POWERS[1 : terms.shape[1]]  # of the derivative
        return self._at(times, *found)

    def since(self, time: float) -> Path:
        """Return the path starting at ``time`` [s]; at least the last knot remains."""
        keep = self.times >= time
        keep[-1] = True
        a = self.accelerations
        return self._at(
            self.times[keep],
            self.positions[keep],
            self.velocities[keep],
            None if a is None else a[keep],
        )

    def beside(self, standing: Mapping[str, float]) -> Path:
        """Return the path for all joints of ``standing``, in its order.

        Joints that do not move keep their positions in ``standing`` [rad | m].
        """
        if tuple(standing) == self.joint_names:
            return self
        columns = [list(standing).index(name) for name in self.joint_names]
        still = np.zeros((len(self.times), len(standing)))

        def widened(rows: Array, others: Array) -> Array:
            wide = others.copy()
            wide[:, columns] = rows
            return wide

        a = self.accelerations
        return Path(
            joint_names=tuple(standing),
            times=self.times,
            positions=widened(self.positions, still + list(standing.values())),
            velocities=widened(self.velocities, still),
            accelerations=None if a is None else widened(a, still),
        )

    def _at(self, times: Array, q: Array, qd: Array, qdd: Array | None = None) -> Path:
        return Path(
            joint_names=self.joint_names,
            times=times,
            positions=q,
            velocities=qd,
            accelerations=qdd,
        )


def _intervals(knots: Array, times: Array) -> tuple[NDArray[np.intp], Array, Array]:
    """Return each time's interval, the interval's duration, and its elapsed fraction.

    The duration and the fraction have shape (n, 1).
    """
    k = np.searchsorted(knots, times, side="right") - 1
    k = np.clip(k, 0, len(knots) - 2)
    h = (knots[k + 1] - knots[k])[:, None]
    return k, h, (times - knots[k])[:, None] / h
