"""Forward kinematics of one posture in plain floats.

``ArmChain.forward`` computes many postures at once.  For a single one, numpy's overhead
is most of its time.  Rotations are tuples of nine numbers, row by row.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, final

import numpy as np

from tool0.kinematics.chain import ArmChain, Array
from tool0.kinematics.pose import Nine, Three

_IDENTITY: Nine = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


class OnePosture(NamedTuple):
    """The joints and the flange of an arm, in a frame that does not move."""

    R: Nine
    """The flange's rotation."""
    p: Three
    """The flange's position [m]."""
    axes: tuple[Three, ...]
    """The joints' axes, unit vectors."""
    points: tuple[Three, ...]
    """A point on each axis [m]."""

    def at(self, point: Sequence[float]) -> Three:
        """Return the position of a point that is given in the flange [m]."""
        x, y, z = rotated(self.R, point)
        a, b, c = self.p
        return (a + x, b + y, c + z)

    def velocity(
        self, point: Three, qd: Sequence[float], n_joints: int = 6
    ) -> tuple[Three, Three]:
        """Return the velocity of a point and the angular one [m/s, rad/s].

        Both are those of the link after ``n_joints``, at a point of the fixed frame.
        """
        x, y, z = point
        vx = vy = vz = wx = wy = wz = 0.0
        rows = zip(self.axes[:n_joints], self.points, qd, strict=False)
        for (ax, ay, az), (px, py, pz), speed in rows:
            ax, ay, az = speed * ax, speed * ay, speed * az  # noqa: PLW2901
            rx, ry, rz = x - px, y - py, z - pz
            vx += ay * rz - az * ry
            vy += az * rx - ax * rz
            vz += ax * ry - ay * rx
            wx += ax
            wy += ay
            wz += az
        return (vx, vy, vz), (wx, wy, wz)

    def efforts(self, force: Three, torque: Three) -> tuple[float, ...]:
        """Return the efforts of the joints that a wrench on the flange causes [N·m].

        It acts at the flange's origin, in the axes of the fixed frame.
        """
        fx, fy, fz = force
        tx, ty, tz = torque
        x, y, z = self.p
        found = []
        for (ax, ay, az), (px, py, pz) in zip(self.axes, self.points, strict=True):
            rx, ry, rz = x - px, y - py, z - pz
            found.append(
                ax * (tx + ry * fz - rz * fy)
                + ay * (ty + rz * fx - rx * fz)
                + az * (tz + rx * fy - ry * fx)
            )
        return tuple(found)


@final
class OnePostureChain:
    """An arm's joints, from a frame that does not move to the flange.

    Each joint's frame is turned so that the joint turns about its z axis: then a turn
    only mixes two columns of the rotation.
    """

    def __init__(self, chain: ArmChain, T_base_chain: Array) -> None:
        """Take the joints of ``chain``; results are in ``base``.

        ``T_base_chain`` is the link that carries the arm in that frame, shape (4, 4).
        """
        steps, last, axes = chain.fixed_parts
        turned = np.eye(4)
        self._steps = []
        for step, axis in zip((T_base_chain @ steps[0], *steps[1:]), axes, strict=True):
            aligned = np.eye(4)
            aligned[:3, :3] = _with_z(axis)
            self._steps.append(parts_of(turned.T @ step @ aligned))
            turned = aligned
        self._last = parts_of(turned.T @ last)

    def forward(self, q: Sequence[float]) -> OnePosture:
        """Return the posture at joint positions ``q`` [rad]."""
        a, b, c, d, e, f, g, h, i = _IDENTITY
        x = y = z = 0.0
        axes, points = [], []
        for (turn, step), angle in zip(self._steps, q, strict=True):
            X, Y, Z = step
            x += a * X + b * Y + c * Z
            y += d * X + e * Y + f * Z
            z += g * X + h * Y + i * Z
            a, b, c, d, e, f, g, h, i = times((a, b, c, d, e, f, g, h, i), turn)
            axes.append((c, f, i))
            points.append((x, y, z))
            cos, sin = math.cos(angle), math.sin(angle)
            a, b = a * cos + b * sin, b * cos - a * sin
            d, e = d * cos + e * sin, e * cos - d * sin
            g, h = g * cos + h * sin, h * cos - g * sin
        turn, step = self._last
        R = (a, b, c, d, e, f, g, h, i)
        dx, dy, dz = rotated(R, step)
        p = (x + dx, y + dy, z + dz)
        return OnePosture(times(R, turn), p, tuple(axes), tuple(points))


def times(first: Nine, second: Nine) -> Nine:
    """Return the product of two rotations."""
    a, b, c, d, e, f, g, h, i = first
    A, B, C, D, E, F, G, H, I = second  # noqa: E741
    return (
        *(a * A + b * D + c * G, a * B + b * E + c * H, a * C + b * F + c * I),
        *(d * A + e * D + f * G, d * B + e * E + f * H, d * C + e * F + f * I),
        *(g * A + h * D + i * G, g * B + h * E + i * H, g * C + h * F + i * I),
    )


def rotated(R: Nine, vector: Sequence[float]) -> Three:
    """Return a vector turned by a rotation."""
    a, b, c, d, e, f, g, h, i = R
    x, y, z = vector
    return (a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z)


def parts_of(T: Array) -> tuple[Nine, Three]:
    """Return the rotation and the position of a homogeneous matrix as numbers."""
    a, b, c, d, e, f, g, h, i = T[:3, :3].ravel().tolist()
    x, y, z = T[:3, 3].tolist()
    return (a, b, c, d, e, f, g, h, i), (x, y, z)


def _with_z(axis: Array) -> Array:
    """Return a rotation whose z axis is a unit vector, shape (3, 3)."""
    other = np.eye(3)[np.argmin(np.abs(axis))]
    x = np.cross(other, axis)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])
