"""Random colors, light and camera poses of copies in each episode."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from tool0.batch.batch import Batch
from tool0.description.camera import Camera
from tool0.description.look import LAMP
from tool0.description.scene import SceneObject
from tool0.description.transform_arrays import from_rotation_vectors, quats_wxyz
from tool0.gym.options import Randomisation


@final
class Looks:
    """Draws the appearance of each copy from the copy's random generator."""

    def __init__(
        self,
        batch: Batch,
        ranges: Randomisation,
        objects: Sequence[SceneObject],
        cameras: Sequence[Camera],
    ) -> None:
        """Prepare to change the task's objects and the cameras of observations."""
        self._batch, self._ranges = batch, ranges
        self._objects, self._cameras = objects, cameras

    def draw(self, i: int, rng: np.random.Generator) -> None:
        """Draw a new appearance of copy ``i``."""
        batch, ranges = self._batch, self._ranges
        for item in self._objects:
            *rgb, alpha = item.rgba
            change = rng.uniform(-ranges.colour, ranges.colour, 3)
            colour = np.clip(np.add(rgb, change), 0.0, 1.0)
            batch.set_colour(item.name, [*colour, alpha], i)
        batch.set_look(
            lamp=LAMP + rng.uniform(-ranges.lamp, ranges.lamp, 3),
            brightness=rng.uniform(*ranges.brightness),
            which=i,
        )
        for camera in self._cameras:
            T = camera.T_link_camera
            away = rng.uniform(-ranges.camera, ranges.camera, 3)
            turn = rng.uniform(-ranges.camera_turn, ranges.camera_turn, (1, 3))
            R = from_rotation_vectors(turn) @ np.array(T.rotation)
            quat = quats_wxyz(R)[0]
            batch.set_camera(camera.name, np.add(T.position, away), quat, i)
