"""Control and simulation of a robot: the options of ``tool0.bringup``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import final

from tool0.description.camera import Camera
from tool0.description.config import SPAWN_Z, File
from tool0.description.scene import Scene
from tool0.description.units import Metres

Names = str | Sequence[str]
"""Names in a sequence, or in one text with spaces between them."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ControlConfig:
    """The controllers, and the initial pose."""

    controllers_file: File | Sequence[File] | None = None
    """YAML files of ros_control, or of ros2_control for a robot with `<ros2_control>`;
    later files override earlier ones.  Without any, the built-in controllers are
    used."""
    controllers: Names | None = None
    """Names of the controllers to load and start; if not given, the standard
    controllers that fit the robot."""
    stopped_controllers: Names | None = None
    """Names of the controllers to load but not start."""
    gripper_action: bool = False
    """Drive built-in grippers with a GripperActionController, whose goals are positions
    of the driven joint, instead of a JointTrajectoryController."""
    initial_pose: str | Mapping[str, float] | None = None
    """A named pose (built-in or saved), or positions by joint [rad | m]; the other
    joints start as in the pose home, or near zero if the file has no such pose."""
    control_period: float | None = None
    """Simulated time between controller updates [s]; if not given, it follows from the
    `update_rate` of ROS 2's controllers, or else equals dt."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class SimulationConfig:
    """The simulation: physics, objects around the robot, and time."""

    engine: str = "mujoco"
    """Physics engine: mujoco, or gazebo (`tool0 gazebo install`)."""
    hardware: str | None = None
    """Address of a real robot's controller, instead of an engine.  tool0 only reads the
    robot's state until you enable motion (docs/how-to/hardware.md)."""
    engine_options: Mapping[str, object] = field(default_factory=dict)
    """Options of the engine by name; Gazebo has ``world`` (a world file that replaces
    the empty world with ground) and ``gui`` (True opens gzclient)."""
    dt: float = 0.001
    """Length of a physics step [s]."""
    spawn_z: Metres = SPAWN_Z
    """Height of the robot's root above the ground [m], as in ur_gazebo, so that the
    outstretched arm clears the ground.  A pedestal fills the gap."""
    scene: Scene | File | None = None
    """The objects around the robot: a YAML file, or a built-in scene (table_and_bin,
    table_and_cubes, shelf)."""
    cameras: tuple[Camera, ...] = ()
    """Further cameras; they replace existing cameras of the same name
    (docs/how-to/cameras.md)."""
    grasp_assist: bool = False
    """Attach a gripped object to the gripper until it opens, regardless of friction
    and force."""
    allow_penetration: bool = False
    """Start even if the initial pose puts a link into the ground, an object or another
    link; the physics then pushes them apart violently."""
    realtime: bool = True
    """Keep pace with the wall clock.  Otherwise, simulate as fast as possible; in
    Python, time then passes only in ``run`` and ``wait``."""
    speed: float = 1.0
    """Simulated seconds per wall second if the simulation runs in real time."""
    paused: bool = False
    """Start paused; `tool0 resume` continues."""
    record: File | None = None
    """Record to this MCAP file, from the start until the end
    (docs/how-to/recordings.md)."""
    overwrite: bool = False
    """Replace the recorded file if it exists."""
