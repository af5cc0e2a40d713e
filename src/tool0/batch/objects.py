"""Objects of the copies: placing, mass, friction and size."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from tool0.batch.arguments import Arguments, Which
from tool0.batch.backend import BatchBackend, ObjectField, changed_object
from tool0.batch.state import State, frozen
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box, Compound, Cylinder, Sphere, sizes
from tool0.errors import ConfigError, ControlError, did_you_mean
from tool0.kinematics.chain import Array
from tool0.simulation.core import Core


@final
class Objects:
    """Checks and makes changes of objects; every argument is as in ``Batch``."""

    def __init__(
        self, copies: BatchBackend, cores: Sequence[Core], state: State
    ) -> None:
        """Change the objects of ``copies``; ``cores`` has the core of each copy."""
        self._copies = copies
        self._cores = cores
        self._state = state
        self.names = tuple(item.name for item in cores[0].scene.objects)
        """The objects of the scene."""
        self._sizes: dict[str, Array] = {}
        """Sizes of objects by name, cached until they change."""

    def check_name(self, name: str) -> None:
        """Raise ControlError if there is no object ``name``."""
        if name not in self.names:
            raise ControlError(
                f"there is no object '{name}'{did_you_mean(name, self.names)}"
            )

    def place(
        self,
        name: str,
        position: ArrayLike,
        quat: ArrayLike | None,
        which: Which | None,
    ) -> None:
        """Place an object at rest; see ``Batch.place``."""
        check = Arguments(self._state.n, "place")
        rows = check.which(which)
        self.check_name(name)
        xyz = check.rows("position", position, (3,), rows)[rows]
        turn = (1.0, 0.0, 0.0, 0.0) if quat is None else quat
        quats = check.rows("quat", turn, (4,), rows)[rows]
        if not (np.abs(quats).max(axis=1, initial=0.0) > 0.0).all():
            raise ControlError("Batch.place: a 'quat' is zero; it must not be")
        with self._state.changing:
            self._copies.place(rows, name, xyz, quats)

    def set_mass(self, name: str, mass: ArrayLike, which: Which | None) -> None:
        """Change the mass of an object; see ``Batch.set_mass``."""
        self._change("set_mass", name, "mass", mass, which)

    def set_friction(self, name: str, friction: ArrayLike, which: Which | None) -> None:
        """Change the friction of an object; see ``Batch.set_friction``."""
        self._change("set_friction", name, "friction", friction, which)

    def set_size(self, name: str, size: ArrayLike, which: Which | None) -> None:
        """Change the size of an object; see ``Batch.set_size``."""
        shape = self._size_shape("set_size", name)
        self._change("set_size", name, "size", size, which, shape=shape)

    def size(self, name: str) -> Array:
        """Return the size of an object; see ``Batch.object_size``."""
        shape = self._size_shape("object_size", name)
        if name not in self._sizes:
            k = self.names.index(name)
            shapes = (core.scene.objects[k].geometry for core in self._cores)
            found = [sizes(each) for each in shapes if not isinstance(each, Compound)]
            whole = (self._state.n, *shape)
            self._sizes[name] = frozen(np.array(found).reshape(whole))
        return self._sizes[name]

    def forget_sizes(self) -> None:
        """Discard the cached sizes, because saved copies are restored."""
        self._sizes.clear()

    def _change(
        self,
        method: str,
        name: str,
        field: ObjectField,
        values: ArrayLike,
        which: Which | None,
        *,
        shape: tuple[int, ...] = (),
    ) -> None:
        """Change a field of an object to one value per copy."""
        check = Arguments(self._state.n, method)
        rows = check.which(which)
        self.check_name(name)
        numbers = check.rows(field, values, shape, rows)[rows]
        item = self._first(name)
        if field == "mass" and item.mass is None:
            raise ControlError(
                f"Batch.{method}: object '{name}' is fixed: it has no mass"
            )
        for i, number in zip(rows.tolist(), numbers.tolist(), strict=True):
            try:
                changed_object(item, field, number)
            except ConfigError as error:
                raise ControlError(f"Batch.{method}: copy {i}: {error}") from None
        with self._state.changing:
            self._copies.change(rows, name, field, numbers)
            self._sizes.pop(name, None)

    def _size_shape(self, method: str, name: str) -> tuple[int, ...]:
        """Return the shape of an object's size.

        Raises:
            ControlError: If the object's size is fixed.
        """
        self.check_name(name)
        geometry = self._first(name).geometry
        match geometry:
            case Box() | Cylinder():
                return (len(sizes(geometry)),)
            case Sphere():
                return ()
        kind = type(geometry).__name__.lower()
        raise ControlError(
            f"Batch.{method}: object '{name}' is a {kind}; only boxes, cylinders and "
            "spheres have a size"
        )

    def _first(self, name: str) -> SceneObject:
        """Return the object of the first copy."""
        return self._cores[0].scene.objects[self.names.index(name)]
