"""Declared surroundings of a real robot, which are not measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final, final

from tool0.description.scene import Scene, SceneObject
from tool0.description.scene_state import Contact, ObjectState
from tool0.description.transform import Vector3, to_transform
from tool0.errors import EngineError
from tool0.hardware.engine import Wrench, check_new_name, find_object

_STANDARD_GRAVITY: Final[Vector3] = (0.0, 0.0, -9.81)
UNKNOWN: Final = "the objects around a real robot are not measured: "


@final
class DeclaredWorld:
    """A ``World`` with objects at their declared poses, for checks and for display."""

    def __init__(self, scene: Scene, ground: float | None) -> None:
        self.gravity: Final = _STANDARD_GRAVITY
        self.ground: Final = ground
        self._objects: dict[str, SceneObject] = {
            item.name: _still(item) for item in scene.objects
        }
        self._states = self._read()

    def object_states(self) -> Sequence[ObjectState]:
        return self._states

    def spawn(self, item: SceneObject) -> None:
        check_new_name(self._objects, item.name)
        self._objects[item.name] = _still(item)
        self._states = self._read()

    def delete(self, name: str) -> None:
        find_object(self._objects, name)
        del self._objects[name]
        self._states = self._read()

    def place(self, state: ObjectState) -> None:
        find_object(self._objects, state.name)
        if any((*state.linear, *state.angular)):
            raise EngineError(f"{UNKNOWN}'{state.name}' is where it was declared")
        self._states = tuple(
            state if item.name == state.name else item for item in self._states
        )

    def contacts(self) -> tuple[Contact, ...]:
        return ()

    def is_touched(self, links: frozenset[str]) -> bool:
        return False

    def center_of_mass(self, name: str) -> Vector3:
        raise EngineError(f"{UNKNOWN}no force can be applied to '{name}'")

    def hold_wrenches(self, wrenches: Mapping[str, Wrench]) -> None:
        if wrenches:
            raise EngineError(f"{UNKNOWN}no force can be applied to them")

    def attach(self, name: str, link: str) -> None:
        raise EngineError(f"{UNKNOWN}'{name}' cannot be fixed to '{link}'")

    def detach(self, name: str) -> None:
        """Do nothing, since objects cannot be attached."""

    def _read(self) -> tuple[ObjectState, ...]:
        return tuple(
            ObjectState(name, item.pose.xyz, to_transform(item.pose).quat_wxyz)
            for name, item in self._objects.items()
        )


def _still(item: SceneObject) -> SceneObject:
    """Return an object, or raise EngineError if it has a mass.

    An object with a mass could move, and this motion would not be measured.
    """
    if item.mass is not None:
        raise EngineError(
            f"{UNKNOWN}'{item.name}' has a mass and could move; declare it without"
        )
    return item
