"""Appearance of each copy of a batch: cameras, light and images."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import final

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tool0.batch.arguments import Arguments, Indices, Which
from tool0.description.camera import Camera
from tool0.description.look import Look
from tool0.description.model import RobotModel
from tool0.description.shapes import RGBA
from tool0.description.transform import from_arrays, to_pose
from tool0.description.transform_arrays import from_quats
from tool0.errors import ControlError
from tool0.protocol.sensors import CameraImage
from tool0.protocol.state import Snapshot
from tool0.sensing.cameras import Cameras, View


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class CopyLook:
    """Appearance of one copy, as the differences from the default appearance."""

    cameras: Mapping[str, Camera] = field(default_factory=dict)
    """Moved cameras, by name."""
    light: Look = Look()
    colours: Mapping[str, RGBA] = field(default_factory=dict)
    """Changed colors of objects, by name of the object."""


@final
class Images:
    """Renderer of the copies.  The batch checks that the copies can be rendered."""

    def __init__(
        self,
        model: RobotModel,
        cameras: Mapping[str, Camera],
        ground: float | None,
        snapshot: Callable[[int], Snapshot],
        *,
        n: int,
        threads: int,
    ) -> None:
        """Prepare rendering without starting OpenGL.

        ``snapshot`` returns a copy's state.
        """
        self._cameras = Cameras(model, cameras, ground, lambda: snapshot(0), threads)
        self._n, self._snapshot = n, snapshot
        self._looks = [CopyLook()] * n

    def render(self, camera: str, rows: Indices) -> tuple[CameraImage, ...]:
        """Return an image of each copy; see ``Batch.render_all``."""
        return tuple(self._cameras.render_all(self._views(camera, rows)))

    def segment(self, camera: str, rows: Indices) -> tuple[NDArray[np.int32], ...]:
        """Return segmentation images; see ``Batch.segment_all``."""
        return tuple(self._cameras.segment_all(self._views(camera, rows)))

    def set_camera(
        self, name: str, position: ArrayLike, quat: ArrayLike, which: Which | None
    ) -> None:
        """Move a camera of copies; see ``Batch.set_camera``."""
        check = Arguments(self._n, "set_camera")
        rows = check.which(which)
        p = check.rows("position", position, (3,), rows)[rows]
        orientation = check.rows("quat", quat, (4,), rows, " for w, x, y, z")[rows]
        if not np.linalg.norm(orientation, axis=1).all():
            raise ControlError("Batch.set_camera: 'quat' has a zero row")
        camera = self._cameras[name]
        poses = zip(rows.tolist(), p, from_quats(orientation), strict=True)
        for i, place, R in poses:
            moved = replace(camera, pose=to_pose(from_arrays(place, R)))
            cameras = {**self._looks[i].cameras, name: moved}
            self._looks[i] = replace(self._looks[i], cameras=cameras)

    def set_look(
        self, lamp: ArrayLike, brightness: ArrayLike, which: Which | None
    ) -> None:
        """Change the light; see ``Batch.set_look``."""
        check = Arguments(self._n, "set_look")
        rows = check.which(which)
        places = check.rows("lamp", lamp, (3,), rows)[rows].tolist()
        levels = check.rows("brightness", brightness, (), rows)[rows].tolist()
        lights = [
            Look(lamp=(x, y, z), brightness=level)
            for (x, y, z), level in zip(places, levels, strict=True)
        ]
        for i, light in zip(rows.tolist(), lights, strict=True):
            self._looks[i] = replace(self._looks[i], light=light)

    def set_colour(self, name: str, rgba: ArrayLike, which: Which | None) -> None:
        """Change the color of an object; see ``Batch.set_colour``."""
        check = Arguments(self._n, "set_colour")
        rows = check.which(which)
        given = check.rows("rgba", rgba, (4,), rows)[rows]
        if (given < 0.0).any() or (given > 1.0).any():
            raise ControlError("Batch.set_colour: 'rgba' must be numbers within 0 … 1")
        for i, (r, g, b, a) in zip(rows.tolist(), given.tolist(), strict=True):
            colours = {**self._looks[i].colours, name: (r, g, b, a)}
            self._looks[i] = replace(self._looks[i], colours=colours)

    def save(self) -> tuple[CopyLook, ...]:
        """Return the appearance of each copy."""
        return tuple(self._looks)

    def restore(self, rows: Indices, looks: Sequence[CopyLook]) -> None:
        """Restore the saved appearance of copies, one per row."""
        for i, look in zip(rows.tolist(), looks, strict=True):
            self._looks[i] = look

    def close(self) -> None:
        """Release the OpenGL resources."""
        self._cameras.close()

    def _views(self, camera: str, rows: Indices) -> list[View]:
        usual = self._cameras[camera]
        return [
            View(
                self._looks[i].cameras.get(camera, usual),
                self._coloured(i),
                self._looks[i].light,
            )
            for i in rows.tolist()
        ]

    def _coloured(self, i: int) -> Snapshot:
        """Return the state of a copy, with its object colors."""
        state, colours = self._snapshot(i), self._looks[i].colours
        if not colours:
            return state
        scene = tuple(
            replace(item, rgba=colours.get(item.name, item.rgba))
            for item in state.scene
        )
        return msgspec.structs.replace(state, scene=scene)
