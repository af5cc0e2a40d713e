"""Grasps of an object from above, and the bin for it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

from tool0.description.grasp_frames import grasp_frame, pad_links
from tool0.description.model import ParallelGripper, RobotModel
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box, Compound, Cylinder, Sphere
from tool0.description.transform import Pose, Transform, Vector3, to_transform
from tool0.errors import ControlError

CLEARANCE = 0.003
"""Distance between the fingertips and the surface below the object [m]."""
SLACK = 0.002
"""Total clearance between an object and the open pads, summed over both sides [m]."""
_UPRIGHT = math.cos(math.radians(3.0))


@final
@dataclass(frozen=True, slots=True)
class Grasp:
    """A pose of the gripper at which it can grasp an object."""

    pose: Transform
    """Pose of the frame between the pads when they touch the object, in the root
    frame."""
    width: float
    """Width of the object between the pads [m]."""


def find_grasps(
    item: SceneObject, pose: Transform, largest: float
) -> tuple[Grasp, ...]:
    """Return the grasps from above that hold an upright object at its middle.

    Args:
        item: A box, a sphere, or an upright cylinder.
        pose: Pose of the object, in the root frame.
        largest: Maximum opening of the gripper [m].

    Raises:
        ControlError: If the object is not upright, has another shape, or is too wide.
    """
    geometry = item.geometry
    if isinstance(geometry, Sphere):
        widths = [(pose, 2.0 * geometry.radius)]
    elif isinstance(geometry, Cylinder):
        if abs(pose.rotation[2][2]) < _UPRIGHT:
            raise ControlError(f"'{item.name}' must stand upright to be picked")
        widths = [(pose, 2.0 * geometry.radius)]
    elif isinstance(geometry, Box):
        widths = list(_sides(item.name, geometry, pose))
    else:
        raise _unknown_sides(item)
    fitting = [(frame, width) for frame, width in widths if width <= largest - SLACK]
    if not fitting:
        narrowest = min(width for _, width in widths)
        raise ControlError(
            f"'{item.name}' is {1000 * narrowest:.1f} mm wide, and the gripper opens "
            f"to {1000 * largest:.1f} mm"
        )
    # After a turn of 180 degrees, the pads touch the same sides.  Round objects have no
    # sides.
    turns = (
        (0.0, math.pi)
        if isinstance(geometry, Box)
        else [k * math.pi / 4 for k in range(8)]
    )
    return tuple(
        Grasp(_from_above(frame, turn), width)
        for frame, width in fitting
        for turn in turns
    )


def grasps_from_above(position: Vector3, width: float) -> tuple[Grasp, ...]:
    """Return grasps from above, with the gripper aligned with the root's axes.

    Args:
        position: Position midway between the pads, in the root frame [m].
        width: Width of the object between the pads [m].
    """
    frame = to_transform(Pose(xyz=position))
    return tuple(Grasp(_from_above(frame, k * math.pi / 2.0), width) for k in range(4))


def half_height(item: SceneObject, pose: Transform) -> float:
    """Return the distance from an upright object's middle to its bottom [m]."""
    geometry = item.geometry
    if isinstance(geometry, Sphere):
        return geometry.radius
    if isinstance(geometry, Cylinder):
        return geometry.length / 2.0
    if isinstance(geometry, Box):
        return geometry.size[_upright_axis(item.name, pose)] / 2.0
    raise _unknown_sides(item)


def _unknown_sides(item: SceneObject) -> ControlError:
    what = "has several shapes" if isinstance(item.geometry, Compound) else "is a mesh"
    return ControlError(f"'{item.name}' {what}; pick a box, cylinder or sphere")


def finger_reach(model: RobotModel, gripper: ParallelGripper) -> float:
    """Return the distance between the middle of the pads and the fingertips [m].

    Raises:
        ControlError: If the gripper does not have two pads, or if the shape of a pad
            does not contain a box.
    """
    pad, _ = pad_links(model, gripper)
    T_grasp_pad = grasp_frame(model, gripper, gripper.max_opening, pad).inverse()
    corners = [
        corner
        for shape in model.link(pad).collisions
        if isinstance(shape.geometry, Box)
        for corner in box_corners(
            shape.geometry, T_grasp_pad @ to_transform(shape.origin)
        )
    ]
    if not corners:
        raise ControlError(
            f"how far the fingers of '{gripper.name}' reach is read from the collision "
            f"box of '{pad}'; it has none"
        )
    return max(z for _, _, z in corners)


def _sides(name: str, box: Box, pose: Transform) -> Iterator[tuple[Transform, float]]:
    """Yield frames with z up and y normal to two sides, and the width across them."""
    up = _upright_axis(name, pose)
    columns = list(zip(*pose.rotation, strict=True))
    for k in range(3):
        if k != up:
            yaw = math.atan2(columns[k][1], columns[k][0]) - math.pi / 2.0
            turned = to_transform(Pose(xyz=pose.position, rpy=(0.0, 0.0, yaw)))
            yield turned, box.size[k]


def _upright_axis(name: str, pose: Transform) -> int:
    """Return the index of the vertical axis of an object, which must be upright."""
    heights = [abs(part) for part in pose.rotation[2]]
    up = heights.index(max(heights))
    if heights[up] < _UPRIGHT:
        raise ControlError(f"'{name}' must stand on one of its sides to be picked")
    return up


def _from_above(frame: Transform, turn: float) -> Transform:
    """Return the frame of a gripper that points down, with its pads along y."""
    yaw = math.atan2(frame.rotation[1][0], frame.rotation[0][0]) + turn
    return to_transform(Pose(xyz=frame.position, rpy=(math.pi, 0.0, yaw)))


@final
@dataclass(frozen=True, slots=True)
class Bin:
    """A box that is open at the top, with its sides along the root's axes."""

    lower: Vector3
    """Lower outer corner of the box, in the root frame [m]."""
    upper: Vector3
    """Opposite outer corner of the box, in the root frame [m]."""

    @property
    def center(self) -> Vector3:
        """Middle of the bin's floor, in the root frame [m]."""
        return (
            (self.lower[0] + self.upper[0]) / 2.0,
            (self.lower[1] + self.upper[1]) / 2.0,
            self.lower[2],
        )

    def holds(self, pose: Transform) -> bool:
        """Return whether an object's middle is inside the bin."""
        return all(
            low < part < high
            for low, part, high in zip(
                self.lower, pose.position, self.upper, strict=True
            )
        )


def find_bin(objects: tuple[SceneObject, ...], name: str) -> Bin:
    """Return the bin whose parts have names of the form ``NAME.part``.

    Raises:
        ControlError: If there is no bin with this name.
    """
    parts = [item for item in objects if item.name.startswith(f"{name}.")]
    corners = [
        corner
        for part in parts
        if isinstance(part.geometry, Box)
        for corner in box_corners(part.geometry, to_transform(part.pose))
    ]
    if not corners:
        raise ControlError(
            f"the scene has no bin '{name}': no box is called '{name}.floor' or alike"
        )
    xs, ys, zs = zip(*corners, strict=True)
    return Bin((min(xs), min(ys), min(zs)), (max(xs), max(ys), max(zs)))


def box_corners(box: Box, pose: Transform) -> list[Vector3]:
    """Return the corners of a box with its middle at ``pose``, in the parent frame."""
    x, y, z = (edge / 2.0 for edge in box.size)
    return [
        pose.apply((i * x, j * y, k * z))
        for i in (-1, 1)
        for j in (-1, 1)
        for k in (-1, 1)
    ]
