"""The start of a session as plain data: with its journal, it repeats the session."""

from __future__ import annotations

from msgspec import Struct

from tool0.description.camera import Camera
from tool0.protocol.objects import ObjectInfo
from tool0.protocol.request import Request


class MeshFile(Struct, frozen=True, kw_only=True):
    """A mesh of the robot, or of an object at the start."""

    uri: str
    """URI of the mesh in the URDF, or in the object."""
    path: str
    """Path of the file at that time."""
    sha256: str
    """SHA-256 of its content."""


class Reproduction(Struct, frozen=True, kw_only=True):
    """All that a bring-up depends on, as plain data."""

    versions: dict[str, str]
    """Versions of ``tool0``, ``python`` and the engine's package."""
    platform: str
    """Operating system and processor."""
    kernel: bool
    """Whether compiled code executed the ticks; the results are the same."""
    name: str
    """Name of the robot's model."""
    source: str
    """The xacro or URDF file it was read from."""
    urdf: str
    """The robot as one document."""
    meshes: tuple[MeshFile, ...]
    controllers: str
    """The whole YAML of the controllers, as one text."""
    started: tuple[str, ...]
    """Controllers that were loaded and started, in order."""
    loaded: tuple[str, ...]
    """Controllers that were loaded only."""
    initial_position: dict[str, float]
    """Joint → [rad | m]; mimic joints follow."""
    poses: dict[str, dict[str, float]]
    """The named poses: joint → [rad | m]."""
    scene: tuple[ObjectInfo, ...]
    """The objects at the start."""
    cameras: tuple[Camera, ...]
    engine: str
    engine_options: dict[str, str | bool | int | float | None]
    dt: float
    """Step of the physics [s]."""
    control_period: float
    """Control period [s]."""
    gravity: tuple[float, float, float]
    """Gravity in the world [m/s²]."""
    spawn_z: float
    """Height of the robot's root above the ground [m]."""
    grasp_assist: bool


class ReadReproduction(Request[Reproduction], frozen=True):
    """Read all that is needed to bring the same robot up again, as it started."""
