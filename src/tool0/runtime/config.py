"""How a robot is controlled and simulated: what ``tool0.bringup`` takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import final

from tool0.description.camera import Camera
from tool0.description.config import File
from tool0.description.scene import Scene

Names = str | Sequence[str]
"""Names in a sequence, or in one text with spaces between them."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ControlConfig:
    """Which controllers to load, and where the robot starts."""

    controllers_file: File | Sequence[File] | None = None
    """YAML files of ros_control, later ones override; if not given, the built-in
    controllers of the robot."""
    controllers: Names | None = None
    """Names of the controllers to load and start."""
    stopped_controllers: Names | None = None
    """Names of the controllers to load but not start."""
    initial_pose: str | Mapping[str, float] | None = None
    """A named pose (built-in or saved), or positions by joint [rad | m] that replace
    those of the default pose home."""
    control_period: float | None = None
    """Simulated time between controller updates [s]; dt if not given."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class SimulationConfig:
    """The physics, the objects around the robot, and how time passes."""

    engine: str = "mujoco"
    """The physics engine: mujoco, or gazebo (`tool0 gazebo install`)."""
    engine_options: Mapping[str, object] = field(default_factory=dict)
    """Options of the engine by name; Gazebo has ``world`` (a world file instead of an
    empty world with ground) and ``gui`` (True opens gzclient)."""
    dt: float = 0.001
    """Length of a physics step [s]."""
    spawn_z: float = 0.1
    """Height of the robot's root above the ground [m], as in ur_gazebo: the
    outstretched arm must clear the ground."""
    scene: Scene | File | None = None
    """The objects around the robot: a YAML file, or a built-in scene (table_and_bin,
    table_and_cubes)."""
    cameras: tuple[Camera, ...] = ()
    """Further cameras; one with the name of another replaces it (docs/camera.md)."""
    grasp_assist: bool = False
    """A cheat: attach a gripped object to the gripper until it opens, whatever
    friction and force are."""
    realtime: bool = True
    """Keep pace with the wall clock; otherwise time passes only in ``run`` and
    ``wait``, as fast as possible."""
    speed: float = 1.0
    """Simulated seconds per wall second in real time."""
    paused: bool = False
    """Start paused (`tool0 resume`)."""
