"""What is around the robot now: objects that come, go and are put somewhere."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import final

from tool0.description.kinematics import Quaternion
from tool0.description.model import RobotModel, Vector3
from tool0.description.scene import Scene, SceneObject
from tool0.errors import ControlError
from tool0.hardware.engine import Engine, ObjectState


@final
class Surroundings:
    """The engine's scene.  Only the thread that owns the tick may touch it."""

    def __init__(self, model: RobotModel, engine: Engine, scene: Scene) -> None:
        """Take over what the engine was made with."""
        self._model = model
        self._world = engine.world
        self.objects: tuple[SceneObject, ...] = scene.objects
        """In the order of the engine's states."""

    def spawn(self, item: SceneObject) -> None:
        """Put a further object there.

        Raises:
            ConfigError: If it has the name of a link.
            ModelError: If the engine cannot have such an object.
            EngineError: If the name is taken, or the engine refuses.
        """
        Scene((item,)).check_beside(self._model)
        self._world.spawn(item)
        self.objects = (*self.objects, item)

    def delete(self, name: str) -> None:
        """Take an object away, or raise EngineError if there is none."""
        self._world.delete(name)
        self.objects = tuple(item for item in self.objects if item.name != name)

    def place(self, state: ObjectState) -> None:
        """Put an object somewhere.

        Raises:
            ControlError: If the state is not finite, or its quaternion has no length.
            EngineError: If there is no such object, or it cannot move so.
        """
        length = math.hypot(*state.quat_wxyz)
        values = (*state.position, *state.linear, *state.angular)
        if not (all(map(math.isfinite, values)) and 0.0 < length < math.inf):
            raise ControlError(
                f"object '{state.name}' needs a finite position and velocity and a "
                f"quaternion of some length, got {state}"
            )
        w, x, y, z = (part / length for part in state.quat_wxyz)
        self._world.place(replace(state, quat_wxyz=(w, x, y, z)))


def object_state(
    name: str,
    position: Sequence[float],
    quat_wxyz: Sequence[float],
    linear: Sequence[float],
    angular: Sequence[float],
) -> ObjectState:
    """Return the state that a person wrote in any kind of sequence."""
    return ObjectState(
        name,
        three_numbers(name, "position", position),
        _quaternion(name, quat_wxyz),
        three_numbers(name, "linear velocity", linear),
        three_numbers(name, "angular velocity", angular),
    )


def three_numbers(name: str, what: str, values: Sequence[float]) -> Vector3:
    """Return what a person wrote of an object, or raise ControlError."""
    if len(values) != 3:
        raise ControlError(
            f"the {what} of object '{name}' has three parts, got {len(values)}"
        )
    x, y, z = map(float, values)
    return x, y, z


def _quaternion(name: str, values: Sequence[float]) -> Quaternion:
    if len(values) != 4:
        raise ControlError(
            f"the quaternion of object '{name}' has four parts, w x y z, "
            f"got {len(values)}"
        )
    w, x, y, z = map(float, values)
    return w, x, y, z
