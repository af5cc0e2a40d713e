"""A simple model from URDF or SDF, as a value: one rigid body of one shape."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

from tool0.description.scene import DEFAULT_FRICTION, RGBA, SceneObject
from tool0.description.shapes import Geometry
from tool0.description.transform import Transform, to_pose

UNPAINTED: RGBA = (0.7, 0.7, 0.7, 1.0)
"""Grey, as Gazebo shows what names no colour."""

_NAMED: dict[str, RGBA] = {
    "black": (0.0, 0.0, 0.0, 1.0),
    "blue": (0.0, 0.0, 1.0, 1.0),
    "darkgrey": (0.175, 0.175, 0.175, 1.0),
    "green": (0.0, 1.0, 0.0, 1.0),
    "grey": (0.7, 0.7, 0.7, 1.0),
    "indigo": (0.33, 0.0, 0.5, 1.0),
    "orange": (1.0, 0.51, 0.0, 1.0),
    "purple": (1.0, 0.0, 1.0, 1.0),
    "red": (1.0, 0.0, 0.0, 1.0),
    "turquoise": (0.0, 1.0, 1.0, 1.0),
    "white": (1.0, 1.0, 1.0, 1.0),
    "wood": (0.65, 0.5, 0.33, 1.0),
    "yellow": (1.0, 1.0, 0.0, 1.0),
}


def gazebo_colour(name: str) -> RGBA | None:
    """Return what ``Gazebo/Red`` and the like look like; None for textures."""
    return _NAMED.get(name.removeprefix("Gazebo/").lower())


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RigidModel:
    """The model of an object, with the frames that Gazebo has for it."""

    name: str
    """As in its text."""
    geometry: Geometry
    link: str = "link"
    collision: str = "collision"
    T_model_link: Transform = field(default_factory=Transform)
    T_model_shape: Transform = field(default_factory=Transform)
    """Where the origin of the shape, which is the object's, sits in the model."""
    placement: Transform = field(default_factory=Transform)
    """The model's own ``<pose>``, in the pose that it is asked to have."""
    mass: float | None = None
    """[kg]; None stands still."""
    friction: float = DEFAULT_FRICTION
    rgba: RGBA = UNPAINTED

    def scene_object(self, name: str, T_root_model: Transform) -> SceneObject:
        """Return the object with the model's frame there; raises ConfigError."""
        return SceneObject(
            name=name,
            geometry=self.geometry,
            pose=to_pose(T_root_model @ self.T_model_shape),
            mass=self.mass,
            friction=self.friction,
            rgba=self.rgba,
        )
