"""The static content of a recording, such as its robot, meshes and controllers."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final

import msgspec
from msgspec import Struct

from tool0.description.scene import SceneObject
from tool0.description.shapes import Geometry, Mesh, placed_geometries
from tool0.protocol.robot import (
    ReadDescription,
    ReadInfo,
)
from tool0.simulation.handlers.reproduction import reproduction
from tool0.simulation.handlers.table import answer

if TYPE_CHECKING:
    from tool0.recording.mcap_file import McapFile
    from tool0.simulation.simulation import Simulation

FORMAT: Final = 1
"""Version of the format, which is incremented when older readers would misread the
file."""
METADATA: Final = "tool0"
MESHES: Final = "tool0.meshes"
"""Name of the metadata that maps each mesh's URI to the name of its attachment."""
ROBOT: Final = "robot.urdf"
DESCRIPTION: Final = "description.json"
SIMULATION: Final = "simulation.json"
BRINGUP: Final = "bringup.json"
"""Attachment with all data that is needed to bring up the same robot again."""
CONTROLLERS: Final = "controllers.yaml"
_JSON: Final = "application/json"


@final
class RecordingInfo(Struct, frozen=True, kw_only=True):
    """Static content of a recording, such as its version, engine and start time."""

    format: int = FORMAT
    version: str
    """Version of tool0."""
    engine: str
    """Physics engine: mujoco or gazebo."""
    wall_start: float
    """Wall time at which the recording began [s since 1970 UTC]."""
    part: int = 1
    """Number of this file within the recording, which may be split into several."""
    first_file: str = ""
    """Name of the first file of the recording; it is empty in the first file."""
    control_period: float
    """Duration of a tick in simulated time [s]."""
    root: str
    """The root link of the robot; the poses of objects are in this link's frame."""
    joint_names: tuple[str, ...]
    """Names of the joints, in the order of the arrays' columns."""

    def metadata(self) -> dict[str, str]:
        """Return the content as MCAP metadata, which maps names to strings."""
        plain = msgspec.to_builtins(self)
        return {
            key: value
            if isinstance(value, str)
            else msgspec.json.encode(value).decode()
            for key, value in plain.items()
        }


def info_from(metadata: Mapping[str, str]) -> RecordingInfo:
    """Return the values that ``metadata`` wrote, or raise msgspec.ValidationError."""
    texts = {
        name
        for name, kind in RecordingInfo.__annotations__.items()
        if kind in ("str", str)
    }
    plain: dict[str, Any] = {
        key: value if key in texts else msgspec.json.decode(value)
        for key, value in metadata.items()
        if key in RecordingInfo.__struct_fields__
    }
    return msgspec.convert(plain, RecordingInfo)


@final
class Contents:
    """Static content at the start of each file, collected once per recording."""

    def __init__(self, simulation: Simulation) -> None:
        from importlib.metadata import version

        snapshot = simulation.snapshot
        self._model = simulation.description.model
        self._description = answer(simulation, ReadDescription())
        self._simulation = answer(simulation, ReadInfo())
        self._bringup = reproduction(simulation)
        geometries: list[Geometry] = []
        for link in self._model.links:
            geometries += [shape.geometry for shape in link.visuals]
            geometries += [shape.geometry for shape in link.collisions]
        self._meshes = _meshes(geometries)
        self._info = RecordingInfo(
            version=version("tool0"),
            engine=simulation.engine.name,
            wall_start=round(time.time(), 3),
            control_period=simulation.loop.control_period,
            root=self._model.root,
            joint_names=snapshot.joint_names,
        )

    @property
    def joint_names(self) -> tuple[str, ...]:
        return self._info.joint_names

    def write(self, file: McapFile, part: int, first: Path) -> None:
        """Write the static content into a new file, which has the number ``part``."""
        info = msgspec.structs.replace(
            self._info, part=part, first_file="" if part == 1 else first.name
        )
        file.note(METADATA, info.metadata())
        file.attach(ROBOT, "application/xml", self._description.urdf.encode())
        file.attach(DESCRIPTION, _JSON, msgspec.json.encode(self._description))
        file.attach(SIMULATION, _JSON, msgspec.json.encode(self._simulation))
        file.attach(BRINGUP, _JSON, msgspec.json.encode(self._bringup))
        file.attach(CONTROLLERS, "application/yaml", self._bringup.controllers.encode())
        attach_meshes(file, self._meshes)


def attach_meshes(file: McapFile, meshes: Mapping[str, Path], first: int = 0) -> None:
    """Attach mesh files by URI, with numbers starting at ``first``."""
    names = {
        uri: f"meshes/{number}-{path.name}"
        for number, (uri, path) in enumerate(meshes.items(), first)
    }
    for uri, name in names.items():
        file.attach(name, "model/mesh", meshes[uri].read_bytes())
    if names:
        file.note(MESHES, names)


def object_meshes(objects: Iterable[SceneObject]) -> dict[str, Path]:
    """Return the mesh files of objects, by the URIs in the shapes of the objects."""
    parts = (part for item in objects for part, _ in placed_geometries(item.geometry))
    return {str(path): path for path in _meshes(parts).values()}


def _meshes(shapes: Iterable[Geometry]) -> dict[str, Path]:
    return {shape.uri: shape.path for shape in shapes if isinstance(shape, Mesh)}
