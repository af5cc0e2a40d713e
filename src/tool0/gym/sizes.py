"""The sizes of a task's objects, which may differ between episodes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from tool0.batch.backend import CPU
from tool0.batch.batch import Batch
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box, Cylinder, Sphere, extents, sizes
from tool0.errors import ConfigError
from tool0.gym.options import EnvOptions
from tool0.gym.task import Mask, Task
from tool0.gym.workspace import Workspace
from tool0.kinematics.chain import Array


@final
class Sizes:
    """Random object sizes in n copies of a task: the scene's sizes, randomly scaled."""

    def __init__(
        self,
        task: Task,
        items: Sequence[SceneObject],
        workspace: Workspace,
        options: EnvOptions,
        n: int,
    ) -> None:
        """Start with the object sizes in the scene.

        Raises:
            ConfigError: If this task does not support ``Randomisation.size``, or
                ``Task.resizable`` is wrong.
        """
        name = type(task).__name__
        possible = [item.name for item in items if item.mass and _own_size(item).size]
        for each in task.resizable:
            if each not in possible:
                raise ConfigError(
                    f"task {name}: resizable names '{each}', which is no box, cylinder "
                    "or sphere with a mass among its objects"
                )
        self.names = task.resizable if workspace.has_sizes else ()
        """Names of the objects with random sizes."""
        if workspace.has_sizes and not self.names:
            raise ConfigError(
                f"randomise.size: the sizes of the objects of {name} are fixed; leave "
                "it out, or name objects in Task.resizable"
            )
        if self.names and options.device != CPU:
            raise ConfigError(
                "randomise.size works with device='cpu' only; this is "
                f"'{options.device}'"
            )
        if task.hold is not None and items[0].name in self.names:
            raise ConfigError(
                f"task {name}: '{items[0].name}' cannot be resizable: starts have it "
                "in the gripper, as Task.hold says"
            )
        self._resized = {
            k: (item.name, _own_size(item))
            for k, item in enumerate(items)
            if item.name in self.names
        }
        """Name and original size of each object with a random size, by the object's
        number."""
        self._own = np.reshape([_extents(item) for item in items], (len(items), 3))
        ranges = [workspace.size_factors(self._own[k]) for k in self._resized]
        self._ranges = np.reshape(ranges, (len(self._resized), 2))
        self.extents = np.tile(self._own, (n, 1, 1))
        """Sizes of the objects, as in ``State.object_size``, shape (n, k, 3)."""

    def draw(self, rng: np.random.Generator) -> Array:
        """Return random size factors of all objects, (k,).

        The factor of an object of constant size is 1.
        """
        factors = np.ones(len(self._own))
        if self.names:
            factors[[*self._resized]] = rng.uniform(*self._ranges.T)
        return factors

    def apply(self, batch: Batch, factors: Array, which: Mask) -> None:
        """Scale the objects of copies by these factors, shape (n, k)."""
        if not self.names:
            return
        found = self._own * factors[..., None]
        self.extents = np.where(which[:, None, None], found, self.extents)
        for k, (name, own) in self._resized.items():
            size = own * factors[:, k, None]
            batch.set_size(name, size if own.size > 1 else size[:, 0], which)

    def risen(self, places: Array) -> Array:
        """Return places (n, k, 3) [m], adjusted to keep the heights of the bottoms."""
        if not self.names:
            return places
        higher = (self.extents - self._own)[..., 2] / 2.0
        places = places.copy()
        for k in self._resized:
            places[:, k, 2] += higher[:, k]
        return places


def _own_size(item: SceneObject) -> Array:
    """Return the dimensions of an object [m], or () for a mesh or a compound."""
    if isinstance(item.geometry, Box | Cylinder | Sphere):
        return np.array(sizes(item.geometry))
    return np.empty(0)


def _extents(item: SceneObject) -> tuple[float, ...]:
    """Return the extents of an object, as in ``State.object_size``."""
    if isinstance(item.geometry, Box | Cylinder | Sphere):
        return extents(item.geometry)
    return (np.nan,) * 3
