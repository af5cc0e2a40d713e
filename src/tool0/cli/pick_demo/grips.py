"""Where a parallel gripper that comes down from above can take an object."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

from tool0.cli.pick_demo.bin import box_corners
from tool0.description.model import ParallelGripper, RobotModel
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box, Cylinder, Sphere
from tool0.description.transform import Pose, Transform, to_transform
from tool0.errors import ControlError
from tool0.sensing.pads import grasp_frame, pad_links

CLEARANCE = 0.003
"""Between finger tips and what the object stands on [m]."""
SLACK = 0.002
"""Room that an object must leave between open pads, both sides together [m]."""
_UPRIGHT = math.cos(math.radians(3.0))


@final
@dataclass(frozen=True, slots=True)
class Grip:
    """One way to take an object."""

    pose: Transform
    """Of the frame between the pads when they touch it, in the root."""
    width: float
    """Of the object between the pads [m]."""


def grips(item: SceneObject, pose: Transform, largest: float) -> tuple[Grip, ...]:
    """Return the ways to take an upright object from above, at its middle.

    Args:
        item: A box, a sphere, or a cylinder that stands.
        pose: Where it is, in the root.
        largest: The gripper's widest opening [m].

    Raises:
        ControlError: If it lies on an edge, is a mesh, or is too wide to take.
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
        raise ControlError(f"'{item.name}' is a mesh; pick a box, cylinder or sphere")
    fitting = [(frame, width) for frame, width in widths if width <= largest - SLACK]
    if not fitting:
        narrowest = min(width for _, width in widths)
        raise ControlError(
            f"'{item.name}' is {1000 * narrowest:.1f} mm wide, and the gripper opens "
            f"to {1000 * largest:.1f} mm"
        )
    # Turned by half, the same pads touch the same sides; a round thing has no sides.
    turns = (
        (0.0, math.pi)
        if isinstance(geometry, Box)
        else [k * math.pi / 4 for k in range(8)]
    )
    return tuple(
        Grip(_from_above(frame, turn), width)
        for frame, width in fitting
        for turn in turns
    )


def half_height(item: SceneObject, pose: Transform) -> float:
    """Return how far an upright object reaches below its middle [m]."""
    geometry = item.geometry
    if isinstance(geometry, Sphere):
        return geometry.radius
    if isinstance(geometry, Cylinder):
        return geometry.length / 2.0
    if isinstance(geometry, Box):
        return geometry.size[_upright_axis(item.name, pose)] / 2.0
    raise ControlError(f"'{item.name}' is a mesh; pick a box, cylinder or sphere")


def reach_below(model: RobotModel, gripper: ParallelGripper) -> float:
    """Return how far the fingers reach beyond the middle of the pads [m].

    Raises:
        ControlError: If the gripper has no two pads, or their shape is no box.
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
            f"how far the fingers of '{gripper.name}' reach is told by the collision "
            f"box of '{pad}'; it has none"
        )
    return max(z for _, _, z in corners)


def _sides(name: str, box: Box, pose: Transform) -> Iterator[tuple[Transform, float]]:
    """Yield frames with z up and y across two of the box's sides, and that width."""
    up = _upright_axis(name, pose)
    columns = list(zip(*pose.rotation, strict=True))
    for k in range(3):
        if k != up:
            yaw = math.atan2(columns[k][1], columns[k][0]) - math.pi / 2.0
            turned = to_transform(Pose(xyz=pose.position, rpy=(0.0, 0.0, yaw)))
            yield turned, box.size[k]


def _upright_axis(name: str, pose: Transform) -> int:
    """Return which of the axes of an object is vertical, or raise ControlError."""
    heights = [abs(part) for part in pose.rotation[2]]
    up = heights.index(max(heights))
    if heights[up] < _UPRIGHT:
        raise ControlError(f"'{name}' must stand on one of its sides to be picked")
    return up


def _from_above(frame: Transform, turn: float) -> Transform:
    """Return the frame of a gripper that looks down, its pads along y of ``frame``."""
    yaw = math.atan2(frame.rotation[1][0], frame.rotation[0][0]) + turn
    return to_transform(Pose(xyz=frame.position, rpy=(math.pi, 0.0, yaw)))
