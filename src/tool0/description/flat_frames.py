"""Frames as 12 plain floats, and forward kinematics of such frames for the tick.

For 12 joints, plain floats take less time than one NumPy call per joint would.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import final

import numpy as np

from tool0.description.joint_tree import TreeJoint
from tool0.description.transform import Vector3
from tool0.description.transform_arrays import Array, turn_z_to

Frame = tuple[float, ...]
"""Axes x, y and z of a frame, and its origin, as 12 floats."""
ROOT: Frame = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


@final
class FlatTree:
    """Forward kinematics for a single set of joint positions.

    The frame of each joint is rotated so that the joint acts along the frame's z axis.
    A joint rotation then changes only the x and y axes.
    """

    def __init__(self, joints: Sequence[TreeJoint], root: Array | None = None) -> None:
        """Precompute frames of ``joints``; ``root``, (3, 3), rotates all results."""
        self.turns: list[Array] = [turn_z_to(joint.axis) for joint in joints]
        """Rotation of each joint's frame, shape (3, 3); the third column is the joint's
        axis."""
        self.parents = [joint.parent for joint in joints]
        self.is_prismatic = [joint.is_prismatic for joint in joints]
        self.placements: list[Frame] = []
        """Rotated frame of each joint at position 0, in the rotated frame of its
        parent."""
        first = np.eye(3) if root is None else root
        for (parent, placement, *_), turn in zip(joints, self.turns, strict=True):
            before = self.turns[parent].T if parent >= 0 else first
            rotation = before @ placement[:3, :3] @ turn
            offset = before @ placement[:3, 3]
            self.placements.append(flat_frame(rotation, offset))

    def frames(self, position: Sequence[float]) -> list[Frame]:
        """Return each joint's rotated frame in the root, including the joint's motion.

        ``position`` [rad | m] is in the order of the joints.
        """
        frames: list[Frame] = []
        cos, sin = math.cos, math.sin
        for i, place in enumerate(self.placements):
            ax, ay, az, bx, by, bz, cx, cy, cz, px, py, pz = place
            parent = self.parents[i]
            if parent >= 0:
                (r0, r1, r2, r3, r4, r5, r6, r7, r8, r9, r10, r11) = frames[parent]
                ax, ay, az = (
                    r0 * ax + r3 * ay + r6 * az,
                    r1 * ax + r4 * ay + r7 * az,
                    r2 * ax + r5 * ay + r8 * az,
                )
                bx, by, bz = (
                    r0 * bx + r3 * by + r6 * bz,
                    r1 * bx + r4 * by + r7 * bz,
                    r2 * bx + r5 * by + r8 * bz,
                )
                cx, cy, cz = (
                    r0 * cx + r3 * cy + r6 * cz,
                    r1 * cx + r4 * cy + r7 * cz,
                    r2 * cx + r5 * cy + r8 * cz,
                )
                px, py, pz = (
                    r0 * px + r3 * py + r6 * pz + r9,
                    r1 * px + r4 * py + r7 * pz + r10,
                    r2 * px + r5 * py + r8 * pz + r11,
                )
            q = position[i]
            if self.is_prismatic[i]:
                px, py, pz = px + q * cx, py + q * cy, pz + q * cz
            else:
                c, s = cos(q), sin(q)
                ax, ay, az, bx, by, bz = (
                    c * ax + s * bx,
                    c * ay + s * by,
                    c * az + s * bz,
                    c * bx - s * ax,
                    c * by - s * ay,
                    c * bz - s * az,
                )
            frames.append((ax, ay, az, bx, by, bz, cx, cy, cz, px, py, pz))
        return frames


def flat_frame(rotation: Array, origin: Array) -> Frame:
    """Return the frame with the given rotation, (3, 3), and origin, (3,)."""
    return (*rotation.T.ravel().tolist(), *origin.tolist())


def rotate(frame: Sequence[float], vector: Vector3) -> Vector3:
    """Return a vector, given in ``frame``, in the axes of the frame's parent."""
    x, y, z = vector
    a, b, c, d, e, f, g, h, i = frame[:9]
    return a * x + d * y + g * z, b * x + e * y + h * z, c * x + f * y + i * z


def rotate_back(frame: Sequence[float], vector: Vector3) -> Vector3:
    """Return a vector in the axes of ``frame``; this is the inverse of ``rotate``."""
    x, y, z = vector
    a, b, c, d, e, f, g, h, i = frame[:9]
    return a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z


def compose(outer: Frame, inner: Frame) -> Frame:
    """Return ``inner``, a frame given in ``outer``, in the parent of ``outer``."""
    a, b, c, d, e, f, g, h, i, px, py, pz = inner
    x, y, z = rotate(outer, (px, py, pz))
    return (
        *rotate(outer, (a, b, c)),
        *rotate(outer, (d, e, f)),
        *rotate(outer, (g, h, i)),
        x + outer[9],
        y + outer[10],
        z + outer[11],
    )
