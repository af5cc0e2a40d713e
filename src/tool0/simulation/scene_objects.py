"""The objects around the robot, which can be added, removed and placed at run time."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import final

from tool0.description.model import RobotModel
from tool0.description.scene import Scene, SceneObject
from tool0.description.scene_state import ObjectState
from tool0.errors import ControlError
from tool0.hardware.engine import Engine
from tool0.simulation.applied_wrenches import AppliedWrenches


@final
class SceneObjects:
    """Objects in the engine, and wrenches on these objects.

    Only the thread that executes the tick may use ``SceneObjects``.
    """

    def __init__(self, model: RobotModel, engine: Engine, scene: Scene) -> None:
        """Start with the objects of the scene for which the engine was created."""
        self._model = model
        self._world = engine.world
        self.wrenches = AppliedWrenches(engine.world)
        self.objects: tuple[SceneObject, ...] = scene.objects
        """Objects of the scene, in the same order as the engine's states."""

    def check_names(self, item: SceneObject) -> None:
        """Raise ConfigError if an object has the same name as a link."""
        Scene((item,)).check_beside(self._model)

    def spawn(self, item: SceneObject) -> None:
        """Add an object.

        Raises:
            ConfigError: If the object has the same name as a link.
            ModelError: If the engine does not support the object.
            EngineError: If the name is already used, or the engine cannot add the
                object.
        """
        self.check_names(item)
        self._world.spawn(item)
        self.objects = (*self.objects, item)

    def delete(self, name: str) -> None:
        """Remove an object, or raise EngineError if it does not exist."""
        self._world.delete(name)
        self.wrenches.clear(name)
        self.objects = tuple(item for item in self.objects if item.name != name)

    def changed(self, item: SceneObject) -> None:
        """Record that the engine has changed an object's size, mass or friction."""
        self.objects = tuple(
            item if other.name == item.name else other for other in self.objects
        )

    def place(self, state: ObjectState) -> None:
        """Place an object.

        Raises:
            ControlError: If the state is not finite, or the length of its quaternion is
                0.
            EngineError: If the object does not exist, or cannot have the velocity in
                ``state``.
        """
        length = math.hypot(*state.quat_wxyz)
        values = (*state.position, *state.linear, *state.angular)
        if not (all(map(math.isfinite, values)) and 0.0 < length < math.inf):
            raise ControlError(
                f"object '{state.name}' needs a finite position and velocity, and a "
                f"non-zero quaternion, got {state}"
            )
        w, x, y, z = (part / length for part in state.quat_wxyz)
        self._world.place(replace(state, quat_wxyz=(w, x, y, z)))
