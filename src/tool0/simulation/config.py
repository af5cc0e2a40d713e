"""Options of ``tool0.bringup`` for the control and the simulation of a robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import final

from tool0.description.camera import Camera
from tool0.description.config import SPAWN_Z, File
from tool0.description.scene import Scene
from tool0.description.units import Metres

Names = str | Sequence[str]
"""Names in a sequence, or in one string, separated by spaces."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ControlConfig:
    """The controllers and the initial pose."""

    controllers_file: File | Sequence[File] | None = None
    """YAML files for ros_control, or for ros2_control if the robot has
    `<ros2_control>`.  Later files override earlier files.  If no file is given, the
    built-in controllers are used."""
    controllers: Names | None = None
    """Names of the controllers to load and start.  If no names are given, the standard
    controllers that fit the robot are used."""
    stopped_controllers: Names | None = None
    """Names of the controllers to load but not start."""
    gripper_action: bool = False
    """Control built-in grippers with a GripperActionController instead of a
    JointTrajectoryController.  The goal of a GripperActionController is a position of
    the driven joint."""
    initial_pose: str | Mapping[str, float] | None = None
    """A named pose (built-in or saved), or positions by joint [rad | m].  Joints
    without a position start at their positions in the pose `home`, or near zero if the
    robot has no pose of this name."""
    control_period: float | None = None
    """Simulated time between controller updates [s].  By default, the `update_rate` of
    the ROS 2 controllers determines the time between updates; without an `update_rate`,
    this time is the length of a physics step."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class SimulationConfig:
    """The simulation: physics, objects around the robot, and time."""

    engine: str = "mujoco"
    """Physics engine: mujoco or gazebo (install Gazebo with `tool0 gazebo install`)."""
    hardware: str | None = None
    """Address of a real robot's controller, which replaces the physics engine. tool0
    only reads the robot's state until you enable motion (docs/how-to/hardware.md)."""
    engine_options: Mapping[str, object] = field(default_factory=dict)
    """Options of the engine, by name.  Gazebo has the options ``world`` (a world file
    that replaces the default world, which contains only the ground) and ``gui`` (True
    opens gzclient)."""
    dt: float = 0.001
    """Length of a physics step [s]."""
    spawn_z: Metres = SPAWN_Z
    """Height of the robot's root above the ground [m].  The default is the height used
    in ur_gazebo, at which the extended arm does not touch the ground.  A pedestal is
    placed below the robot."""
    scene: Scene | File | None = None
    """The objects around the robot: a YAML file, or a built-in scene (table_and_bin,
    table_and_cubes, shelf)."""
    cameras: tuple[Camera, ...] = ()
    """Additional cameras, which replace existing cameras of the same name
    (docs/how-to/cameras.md)."""
    grasp_assist: bool = False
    """Attach a gripped object to the gripper until the gripper opens, regardless of
    friction and force."""
    allow_penetration: bool = False
    """Start even if, in the initial pose, a link penetrates the ground, an object or
    another link.  The physics engine then pushes the bodies apart with large forces."""
    realtime: bool = True
    """Synchronize simulated time with the wall clock.  If this option is off, the
    simulation runs as fast as possible; in Python, time then advances only in ``run``
    and ``wait``."""
    speed: float = 1.0
    """Simulated seconds per second of wall time, if simulated time is synchronized with
    the wall clock."""
    paused: bool = False
    """Start the simulation paused; `tool0 resume` resumes it."""
    record: File | None = None
    """MCAP file for a recording of the entire run (docs/how-to/recordings.md)."""
    overwrite: bool = False
    """Overwrite the MCAP file if it exists."""
