"""Closed-form inverse kinematics of UR-like arms, with all postures for a pose.

The first axis of a UR-like arm is vertical. The second, third and fourth axes are
parallel, so that the links between them move in a plane, the *plane of the arm*. The
fifth axis lies in the plane of the arm. The sixth axis is perpendicular to the fifth
axis and intersects it at the *center of the wrist*. The lengths are computed from the
joint axes, so any arm with this geometry is supported. The steps follow K. P. Hawkins,
Analytic Inverse Kinematics for the Universal Robots UR-5/UR-10 Arms (2013),
http://hdl.handle.net/1853/50782, but use vectors instead of Denavit-Hartenberg
parameters.

In the coordinates of this module, z is the first axis and y is the second axis. The
plane of the arm is spanned by z and x. Angles in the plane of the arm are measured from
z to x, in the direction in which the joints turn.
"""

from __future__ import annotations

from typing import NamedTuple, final

import numpy as np

from tool0.errors import ControlError
from tool0.kinematics.chain import ArmChain, Array

N_BRANCHES = 8
ROUNDING = 1e-6
"""Tolerance at the boundary of the workspace, relative to the squared length."""
INEXACT = 20.0
"""Additional tolerance per radian of deviation from the ideal geometry. Solutions
within the additional tolerance are refined and are discarded if they do not reach the
pose."""
SINGULAR = 1e-5
"""Sine of the fifth joint's angle below which only the sum of the fourth and sixth
joint positions determines the pose."""
MAX_INEXACT = 0.1
"""Maximum accepted deviation from the ideal geometry [rad]. Solutions are refined."""


class Signs(NamedTuple):
    """Functions of a posture that are zero at the singularity between two branches."""

    shoulder: Array
    """Distance of the wrist center in front of the shoulder [m]; it is negative behind
    the shoulder."""
    elbow: Array
    """Sine of the angle from the upper arm to the forearm."""
    wrist: Array
    """Sine of the angle from the second axis to the sixth axis about the fifth axis."""


@final
class ArmGeometry:
    """Lengths of an arm, and its inverse kinematics without joint limits."""

    def __init__(self, chain: ArmChain) -> None:
        """Compute the lengths from the joint axes with all joints at 0.

        Raises:
            ControlError: If the geometry of the arm is not supported.
        """
        T, axes, points = (item[0] for item in chain.forward(np.zeros((1, 6))))
        z = axes[0]
        y = _unit(axes[1] - z * (axes[1] @ z))
        self._signs = np.ones(6)
        self._signs[1:4] = np.sign(axes[1:4] @ y)
        self._R = np.array([np.cross(y, z), y, z])
        """Rotation from the base frame's axes to the axes of this module."""
        self._origin = points[0] + z * ((points[1] - points[0]) @ z)
        axes = axes @ self._R.T
        x2, elbow, wrist = ((points[1:4] - self._origin) @ self._R.T)[:, [2, 0]]
        self.upper_arm, self.forearm = _norm(elbow - x2), _norm(wrist - elbow)
        """Lengths of the upper arm and the forearm [m]."""
        self._upper_angle, self._fore_angle = _angle(elbow - x2), _angle(wrist - elbow)
        fifth, sixth = (points[4:] - self._origin) @ self._R.T
        centre = _nearest(sixth, axes[5], fifth, axes[4])
        self.lateral = float(centre[1])
        """Offset of the wrist center along y from the first axis [m]."""
        self._fifth_angle = _angle(axes[4, [2, 0]])
        fifth_direction = np.array(
            [np.cos(self._fifth_angle), np.sin(self._fifth_angle)]
        )
        self.wrist = float((centre[[2, 0]] - wrist) @ fifth_direction)
        """Distance from the fourth axis to the wrist center [m]."""
        across = np.cross(axes[4], [0.0, 1.0, 0.0])
        self._sixth_angle = np.arctan2(axes[5] @ across, axes[5, 1])
        # Frame at the wrist center: z is the sixth axis, x is the fifth axis at zero.
        frame = np.eye(4)
        x6 = _unit(axes[4] - axes[5] * (axes[4] @ axes[5]))
        frame[:3, :3] = self._R.T @ np.column_stack(
            [x6, np.cross(axes[5], x6), axes[5]]
        )
        frame[:3, 3] = self._R.T @ centre + self._origin
        self._T_tip_wrist = np.linalg.inv(T) @ frame
        self._slack = ROUNDING
        self.inexact = self._check(chain)
        """Approximate deviation from the ideal geometry [rad]."""
        self._slack += INEXACT * self.inexact

    @property
    def reach(self) -> float:
        """Maximum distance from shoulder to wrist center in the arm's plane [m]."""
        return self.upper_arm + self.forearm + abs(self.wrist)

    def wrist_centre(self, T_base_tip: Array) -> Array:
        """Return the wrist center relative to the shoulder [m], shape (n, 3)."""
        T = T_base_tip @ self._T_tip_wrist
        return np.asarray((T[:, :3, 3] - self._origin) @ self._R.T)

    def solve(self, T_base_tip: Array, sixth: Array | None = None) -> Array:
        """Return the postures for each pose; NaN for branches without a posture.

        Args:
            T_base_tip: Target pose of the flange, shape (n, 4, 4).
            sixth: Position of the sixth joint [rad], shape (n,), for singular poses,
                which do not determine it. If ``sixth`` is specified, the sixth joint
                has this position in all solutions.

        Returns:
            Joint positions modulo whole turns [rad], shape (n, 8, 6).
        """
        R6 = self._R @ (T_base_tip @ self._T_tip_wrist)[:, :3, :3]
        centre = self.wrist_centre(T_base_tip)
        # Each choice between two solutions adds an array axis: shoulder, wrist, elbow.
        x, y, z = centre.T[..., None]
        either = np.array([1.0, -1.0])
        with np.errstate(invalid="ignore", divide="ignore"):
            beside = x * x + y * y
            forward = either * self._root(beside - self.lateral**2, beside)
            q1 = np.arctan2(y, x) - np.arctan2(self.lateral, forward)
            # Rotate the vectors about z into the plane of the arm.
            x6, z6 = (_turned_back(R6[:, None, :, k], q1)[:, :, None] for k in (0, 2))
            aside = either * np.hypot(z6[..., 0], z6[..., 2])
            if sixth is None:
                q5 = np.arctan2(aside, z6[..., 1])
                # -(z6 x y): in the arm's plane, along the fifth axis
                z5 = _row(z6[..., 2], 0.0, -z6[..., 0]) / aside[..., None]
                q6 = _turn_about(z6, z5, x6)
            else:
                q5 = np.arctan2(0.0 * aside, z6[..., 1])
                q6 = np.broadcast_to(sixth[:, None, None], q5.shape)
                z5 = _rotated(x6, z6, -q6)
            total = np.arctan2(z5[..., 0], z5[..., 2])
            joint4 = _row(
                z[..., None] - self.wrist * np.cos(total),
                forward[..., None] - self.wrist * np.sin(total),
            )
            bend = either * self._bend(joint4)[..., None]
            upper = np.arctan2(joint4[..., 1], joint4[..., 0])[..., None] - np.arctan2(
                self.forearm * np.sin(bend),
                self.upper_arm + self.forearm * np.cos(bend),
            )
        q2 = upper - self._upper_angle
        q3 = bend - (self._fore_angle - self._upper_angle)
        q4 = (total - self._fifth_angle)[..., None] - q2 - q3
        q = np.empty((*q2.shape, 6))
        q[..., 0] = q1[..., None, None]
        q[..., 1], q[..., 2], q[..., 3] = q2, q3, q4
        q[..., 4] = (q5 - self._sixth_angle)[..., None]
        q[..., 5] = q6[..., None]
        return q.reshape(len(q), N_BRANCHES, 6) * self._signs

    def signs(self, q: Array) -> Signs:
        """Return, for n postures, the side of each singularity; each has shape (n,)."""
        _, q2, q3, q4, q5, _ = (q * self._signs).T
        upper = q2 + self._upper_angle
        fore = q2 + q3 + self._fore_angle
        hand = q2 + q3 + q4 + self._fifth_angle
        forward = (
            self.upper_arm * np.sin(upper)
            + self.forearm * np.sin(fore)
            + self.wrist * np.sin(hand)
        )
        return Signs(forward, np.sin(fore - upper), np.sin(q5 + self._sixth_angle))

    def _bend(self, joint4: Array) -> Array:
        """Return the angle from upper arm to forearm, 0 … π; NaN if out of reach."""
        a, b = self.upper_arm, self.forearm
        cosine = ((joint4**2).sum(axis=-1) - a * a - b * b) / (2.0 * a * b)
        return np.asarray(np.arctan2(self._root(1.0 - cosine**2, 1.0), cosine))

    def _root(self, square: Array, scale: Array | float) -> Array:
        """Return the square root of a value; NaN if the value is too far below 0."""
        within = square > -self._slack * scale
        return np.asarray(np.sqrt(np.where(within, np.abs(square), np.nan)))

    def _check(self, chain: ArmChain) -> float:
        """Return the error of ``solve`` [rad]; raise ControlError if it is large."""
        known = np.array(
            [[0.3, -1.1, 1.3, -0.7, -1.2, 0.4], [-2.0, -2.2, -1.2, 2.5, 0.9, -2.5]]
        )
        known[:, 1:4] -= [self._upper_angle - np.pi / 2, 0.0, 0.0]
        with np.errstate(all="ignore"):
            found = self.solve(chain.forward(known).T_base_tip)
            error = np.abs(wrapped(found - known[:, None])).max(axis=2)
        worst = np.nan_to_num(error, nan=np.inf).min(axis=1).max()
        if not worst < MAX_INEXACT:
            raise ControlError(
                f"the arm that ends at '{chain.tip}' is not built like a UR (axes 2, 3 "
                "and 4 parallel, 1 and 5 across them, 6 across 5), and there is no "
                "inverse kinematics for other arms; use move_joints"
            )
        return float(worst)


def _row(*columns: Array | float) -> Array:
    return np.stack(np.broadcast_arrays(*columns), axis=-1)


def _turned_back(vectors: Array, angle: Array) -> Array:
    """Return ``vectors`` rotated by minus ``angle`` about z."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    c, s = np.cos(angle), np.sin(angle)
    return _row(c * x + s * y, c * y - s * x, z)


def _turn_about(axis: Array, first: Array, second: Array) -> Array:
    """Return the angle from ``first`` to ``second`` about ``axis``."""
    sine = (axis * np.cross(first, second)).sum(axis=-1)
    return np.asarray(np.arctan2(sine, (first * second).sum(axis=-1)))


def _rotated(vectors: Array, axis: Array, angle: Array) -> Array:
    """Return ``vectors``, perpendicular to ``axis``, rotated about ``axis``."""
    c, s = np.cos(angle)[..., None], np.sin(angle)[..., None]
    return np.asarray(c * vectors + s * np.cross(axis, vectors))


def _nearest(point: Array, along: Array, other: Array, other_along: Array) -> Array:
    """Return the point on the first line that is nearest to the second line."""
    n = np.cross(along, other_along)
    square = float(n @ n)
    if square < 0.5:  # nearly parallel axes form no wrist; _check fails
        return point
    distance = float(np.cross(other - point, other_along) @ n) / square
    return np.asarray(point + along * distance)


def wrapped(angle: Array) -> Array:
    """Return angles wrapped to -π … π."""
    return np.asarray(np.remainder(angle + np.pi, 2 * np.pi) - np.pi)


def _angle(direction: Array) -> float:
    return float(np.arctan2(direction[1], direction[0]))


def _norm(vector: Array) -> float:
    return float(np.linalg.norm(vector))


def _unit(vector: Array) -> Array:
    return np.asarray(vector / np.linalg.norm(vector))
