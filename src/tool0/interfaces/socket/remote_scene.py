"""What is around a robot that runs in another process."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from tool0.description.scene import DEFAULT_FRICTION, RGBA
from tool0.description.shapes import Geometry
from tool0.description.transform import Vector3
from tool0.hardware.engine import ObjectState
from tool0.interfaces.socket.params import Params
from tool0.interfaces.socket.requests import Call
from tool0.interfaces.socket.shape_json import shape_from_params, shape_to_json
from tool0.interfaces.socket.wire import Json


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RemoteObject:
    """One row of ``scene list``."""

    name: str
    shape: Geometry
    mass: float | None
    """[kg]; None stands still."""
    friction: float
    state: ObjectState


@final
class RemoteScene:
    """The objects there, with the verbs of ``robot.scene`` in this process."""

    def __init__(self, call: Call) -> None:
        self._call = call

    def list(self) -> tuple[RemoteObject, ...]:
        """Return every object, in the order in which they came."""
        return tuple(_object(row) for row in self._call("scene.list")["objects"])

    def add(
        self,
        name: str,
        shape: Geometry,
        *,
        xyz: Sequence[float] = (0.0, 0.0, 0.0),
        rpy: Sequence[float] = (0.0, 0.0, 0.0),
        mass: float | None = None,
        friction: float = DEFAULT_FRICTION,
        rgba: RGBA | None = None,
    ) -> None:
        """Put a further object there [m, rad, kg]; a mesh must lie on that machine."""
        self._call(
            "scene.add",
            name=name,
            **shape_to_json(shape),
            xyz=[*xyz],
            rpy=[*rpy],
            mass=mass,
            friction=friction,
            rgba=rgba,
        )

    def remove(self, name: str) -> None:
        self._call("scene.remove", name=name)

    def place(
        self, name: str, xyz: Sequence[float], rpy: Sequence[float] = (0.0, 0.0, 0.0)
    ) -> None:
        """Put an object somewhere in the robot's root [m, rad], at rest."""
        self._call("scene.place", name=name, xyz=[*xyz], rpy=[*rpy])


def _object(row: Json) -> RemoteObject:
    position: Vector3 = tuple(row["position"])
    w, x, y, z = row["quat_wxyz"]
    return RemoteObject(
        name=row["name"],
        shape=shape_from_params(Params("scene.list", row["shape"])),
        mass=row["mass"],
        friction=row["friction"],
        state=ObjectState(
            row["name"],
            position,
            (w, x, y, z),
            tuple(row["linear"]),
            tuple(row["angular"]),
        ),
    )
