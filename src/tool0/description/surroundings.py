"""The objects and planes with which a motion could collide, at one moment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, final

from tool0.description.scene import SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.transform import Transform, Vector3


class HeldObject(NamedTuple):
    """An object that moves with a link of a gripper."""

    item: SceneObject
    link: str
    """Name of the gripper's link that carries the fingers."""
    T_link_item: Transform


class Plane(NamedTuple):
    """A plane that the robot must not cross."""

    name: str
    point: Vector3
    """Point on the plane [m], in the robot's root."""
    normal: Vector3
    """Unit normal that points to the robot's side of the plane."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """Positions of the robot's joints, and the objects around the robot."""

    positions: Mapping[str, float]
    """Positions of all movable joints by name [rad | m]."""
    objects: tuple[tuple[SceneObject, ObjectState], ...] = ()
    """Objects around the robot, and the state of each object."""
    held: tuple[HeldObject, ...] = ()
    """Objects that grippers hold and move."""
    planes: tuple[Plane, ...] = ()
