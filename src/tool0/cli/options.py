"""The options of ``bringup``, ``view`` and ``describe``, as values.

No tyro here: ``quick.py`` reads the usual command lines without it.  A field is an
option; the string below it is the option's help.  Left-out options are None where the
façade has its own default, so that a default is written once.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Literal, final

from tool0.errors import ConfigError

DEFAULT_SPAWN_Z = 0.1
"""As ``bringup`` of the runtime has it, for commands that have no physics [m]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RobotOptions:
    """Which robot."""

    arm: str = "ur5"
    """The arm."""
    gripper: str = "2f85"
    """The gripper on the arm's tool0, or none."""
    gripper_model: Literal["mimic", "linkage"] = "mimic"
    """Fingers that follow their drive, or real ones that wrap around (MuJoCo)."""
    prefix: str = ""
    """Put before the name of every link and joint, as in left_."""
    robot: Path | None = None
    """A URDF or xacro file of your own, instead of --arm and --gripper."""
    args: tuple[str, ...] = ()
    """Arguments of the xacro file: name:=value …"""
    mount_xyz: tuple[float, float, float] | None = None
    """Where the gripper sits in tool0 [m]."""
    mount_rpy: tuple[float, float, float] | None = None
    """How it is turned in tool0, roll pitch yaw [rad]."""
    meshes: Literal["tool0", "upstream"] = "tool0"
    """Our low-poly meshes, or those of ur_description and robotiq's package."""
    joint_limit_params: Path | None = None
    """YAML of the joint limits, as in ur_description."""
    kinematics_params: Path | None = None
    """YAML of the kinematics: a calibrated robot's own."""
    physical_params: Path | None = None
    """YAML of masses and inertias."""
    visual_params: Path | None = None
    """YAML of the visual and collision shapes."""
    gripper_params: Path | None = None
    """YAML of the gripper's masses and drive."""
    gripper_joint_limit_params: Path | None = None
    """YAML of the gripper's joint limits."""
    transmission_hw_interface: str | None = None
    """Command interface of the arm: hardware_interface/EffortJointInterface, …"""
    safety_limits: bool = False
    """Soft limits before the hard ones."""
    safety_pos_margin: float | None = None
    """How far before the hard limit the soft one is [rad]."""
    safety_k_position: float | None = None
    """How firmly the soft limit holds [1/s]."""
    tf_prefix: str | None = None
    """Prefix of the frames, as in the original launch file."""
    spawn_z: float | None = None
    """Height of the robot's base above the ground [m]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerOptions:
    """Which controllers."""

    controllers_file: tuple[Path, ...] = ()
    """YAML files of ros_control controllers, instead of the ones that come along."""
    controllers: str | None = None
    """Names of those to start, between spaces."""
    stopped_controllers: str | None = None
    """Names of those to load and leave stopped, between spaces."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class SimulationOptions:
    """How it runs."""

    engine: Literal["mujoco", "gazebo"] = "mujoco"
    """The physics; `tool0 gazebo install` gets a Gazebo."""
    initial_pose: tuple[str, ...] = ()
    """The name of a pose, or joint=position … [rad]."""
    scene: Path | None = None
    """What is around the robot: a YAML file, or table_and_bin or table_and_cubes."""
    world: Path | None = None
    """A world file for Gazebo; if left out, an empty world with ground."""
    gazebo_gui: bool = False
    """Also open Gazebo's own window, gzclient."""
    grasp_assist: bool = False
    """A cheat: fix to the gripper what it grips, until it opens."""
    paused: bool = False
    """Begin paused: `tool0 resume` lets time run."""
    realtime: bool = True
    """Keep to the wall clock; otherwise as fast as possible."""
    speed: float | None = None
    """Simulated seconds per wall second."""
    duration: float | None = None
    """End at this simulated time [s]; otherwise at Ctrl-C."""
    headless: bool = False
    """Serve no panel, and open nothing on the desktop."""
    summary: Literal["text", "json", "none"] = "text"
    """What to print at the end; json prints one object and nothing else."""
    name: str = "tool0"
    """Under what name other processes find this bringup."""
    remote: bool = True
    """Let this user's other processes drive the robot: `tool0 move`, …"""

    def __post_init__(self) -> None:
        if self.duration is not None and not 0.0 <= self.duration < math.inf:
            raise ConfigError(
                f"--duration must be 0 or more seconds, got {self.duration}"
            )
        if self.engine != "gazebo" and (self.world is not None or self.gazebo_gui):
            option = "--world" if self.world is not None else "--gazebo-gui"
            raise ConfigError(
                f"{option} is for Gazebo alone, and the engine is {self.engine}; "
                "add --engine gazebo"
            )


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PanelOptions:
    """The web page that shows and drives the robot."""

    panel_host: str | None = None
    """Where it listens, 0.0.0.0 for everywhere; if left out, only this machine's own
    browsers reach it.  Given, or with --panel-port, the address has a token."""
    panel_port: int | None = None
    """Its port; 8085 if left out, or a free one if that is taken."""
    open: bool = True
    """Open it in a browser, where there is a desktop."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RosOptions:
    """How it appears in ROS 1."""

    ros1: bool = False
    """Present it in ROS 1, as ur_gazebo does; `tool0 ros1 install` gets a ROS."""
    roscore: bool = False
    """Start a roscore if none answers."""
    ns: str = ""
    """Put before all its names in ROS, as robot1: several robots, one roscore."""
    tf_pub_rate: float | None = None
    """Transforms per second [Hz]."""
    camera_rate: float | None = None
    """Pictures of each camera per second [Hz], at most; 10 if left out."""

    def __post_init__(self) -> None:
        is_paced = self.tf_pub_rate is not None or self.camera_rate is not None
        if not self.ros1 and (self.roscore or self.ns or is_paced):
            raise ConfigError(
                "--roscore, --ns, --tf-pub-rate and --camera-rate need --ros1"
            )


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class BringupOptions:
    """Bring a robot up in simulation, its controllers running.

    It holds its pose until it is told otherwise: from the panel, a web page whose
    address is printed; from another terminal with `tool0 move`, `tool0 grip` and
    `tool0 controllers`; or from Python.
    """

    description: RobotOptions = field(default_factory=RobotOptions)
    control: ControllerOptions = field(default_factory=ControllerOptions)
    simulation: SimulationOptions = field(default_factory=SimulationOptions)
    panel: PanelOptions = field(default_factory=PanelOptions)
    ros: RosOptions = field(default_factory=RosOptions)


_EDGE: frozenset[str] = frozenset({"duration", "headless", "summary", "name", "remote"})
"""Options that the command line keeps to itself."""


def bringup_keywords(options: BringupOptions) -> dict[str, object]:
    """Return the keywords of ``tool0.bringup``; what was left out is not in it."""
    keywords = robot_keywords(options.description)
    control, simulation = options.control, options.simulation
    keywords.update(_given(control))
    if control.controllers_file:
        keywords["controllers_file"] = list(control.controllers_file)
    keywords.update(_given(simulation))
    if simulation.initial_pose:
        keywords["initial_pose"] = pose(simulation.initial_pose)
    return keywords


def robot_keywords(options: RobotOptions) -> dict[str, object]:
    """Return the keywords that say which robot."""
    keywords = _given(options)
    if options.args:
        keywords["args"] = assignments(options.args, ":=", "--args")
    return keywords


def pose(words: tuple[str, ...]) -> str | dict[str, float]:
    """Return the name of a pose, or its joints."""
    if len(words) == 1 and "=" not in words[0]:
        return words[0]
    return joint_values(words, "--initial-pose")


def joint_values(words: tuple[str, ...], option: str) -> dict[str, float]:
    """Return ``joint=value …`` as a mapping, or raise ConfigError."""
    values: dict[str, float] = {}
    for name, text in assignments(words, "=", option).items():
        try:
            values[name] = float(text)
        except ValueError:
            values[name] = math.nan
        if not math.isfinite(values[name]):
            raise ConfigError(f"{option}: '{name}={text}': need a finite number")
    return values


def assignments(words: tuple[str, ...], sign: str, option: str) -> dict[str, str]:
    """Return ``name<sign>value …`` as a mapping, or raise ConfigError."""
    found: dict[str, str] = {}
    for word in words:
        name, given, value = word.partition(sign)
        if not (given and name):
            raise ConfigError(f"{option}: '{word}': write name{sign}value")
        if name in found:
            raise ConfigError(f"{option}: '{name}' is given twice")
        found[name] = value
    return found


def _given(group: object) -> dict[str, object]:
    """Return the options that are a keyword of the façade and were not left out."""
    values: Mapping[str, object] = {
        item.name: getattr(group, item.name)
        for item in fields(group)  # type: ignore[arg-type]  # one of the three above
        if item.name not in _EDGE
    }
    return {name: value for name, value in values.items() if value not in (None, ())}
