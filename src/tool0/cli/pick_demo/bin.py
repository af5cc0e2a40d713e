"""The bin of a demo: where an object goes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from tool0.description.scene import SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Transform, Vector3, to_transform
from tool0.errors import ControlError


@final
@dataclass(frozen=True, slots=True)
class Bin:
    """A box that is open above, its sides along the root's axes."""

    lower: Vector3
    """Its corner, outside, in the root [m]."""
    upper: Vector3

    @property
    def center(self) -> Vector3:
        """The middle of its floor [m]."""
        return (
            (self.lower[0] + self.upper[0]) / 2.0,
            (self.lower[1] + self.upper[1]) / 2.0,
            self.lower[2],
        )

    def holds(self, pose: Transform) -> bool:
        """Return whether an object's middle is in it."""
        return all(
            low < part < high
            for low, part, high in zip(
                self.lower, pose.position, self.upper, strict=True
            )
        )


def find_bin(objects: tuple[SceneObject, ...], name: str) -> Bin:
    """Return the bin whose parts are called ``NAME.part``.

    Raises:
        ControlError: If there is none.
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
    """Return the corners of a box, whose middle is at ``pose``, in the frame around."""
    x, y, z = (edge / 2.0 for edge in box.size)
    return [
        pose.apply((i * x, j * y, k * z))
        for i in (-1, 1)
        for j in (-1, 1)
        for k in (-1, 1)
    ]
