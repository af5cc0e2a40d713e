"""The initial state of a session as plain data, for repeating the session's journal."""

from __future__ import annotations

from msgspec import Struct

from tool0.description.camera import Camera
from tool0.protocol.objects import ObjectInfo
from tool0.protocol.request import Request


class MeshFile(Struct, frozen=True, kw_only=True):
    """A mesh of the robot, or of an object at the start of the session."""

    uri: str
    """URI of the mesh in the URDF or in the description of the object."""
    path: str
    """Path of the file at the start of the session."""
    sha256: str
    """SHA-256 of the file's content."""


class Reproduction(Struct, frozen=True, kw_only=True):
    """Everything that a bring-up depends on, as plain data."""

    versions: dict[str, str]
    """Versions of ``tool0``, ``python`` and the engine's package."""
    platform: str
    """Operating system and processor."""
    kernel: bool
    """Whether compiled code executed the ticks.  The results do not depend on this
    value."""
    name: str
    """Name of the robot's model."""
    source: str
    """Path of the xacro or URDF file from which the robot was read."""
    urdf: str
    """URDF of the whole robot as one document."""
    meshes: tuple[MeshFile, ...]
    controllers: str
    """Complete YAML of the controllers, as text."""
    started: tuple[str, ...]
    """Names of the controllers that were loaded and started, in order."""
    loaded: tuple[str, ...]
    """Names of the controllers that were loaded but not started."""
    initial_position: dict[str, float]
    """Joint → initial position [rad | m], without mimic joints."""
    poses: dict[str, dict[str, float]]
    """Named poses of the robot: name → joint → position [rad | m]."""
    scene: tuple[ObjectInfo, ...]
    """Objects in the scene at the start."""
    cameras: tuple[Camera, ...]
    engine: str
    engine_options: dict[str, str | bool | int | float | None]
    dt: float
    """Length of a physics step [s]."""
    control_period: float
    """Control period [s]."""
    gravity: tuple[float, float, float]
    """Gravitational acceleration in the world frame [m/s²]."""
    spawn_z: float
    """Height of the robot's root above the ground [m]."""
    grasp_assist: bool


class ReadReproduction(Request[Reproduction], frozen=True):
    """Read all data that are needed to bring up the same robot again."""
