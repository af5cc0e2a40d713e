"""The options of ``bringup``, ``view`` and ``describe`` as dataclasses.

Each field is an option, and the string below the field is the option's help text.  The
options of the robot, its controllers and its simulation are defined in the classes that
``tool0.bringup`` uses; this module adds only options that exist solely on the command
line.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Final, final

from tool0.cli.parameters import (
    AsJson,
    Option,
    Reader,
    Readers,
    assignments,
    joint_values,
    read_path,
)
from tool0.description.camera import Camera
from tool0.description.config import Argument, Cell, DescriptionConfig, File, Unset
from tool0.description.scene import Scene
from tool0.description.units import (
    ANGLE,
    LENGTH,
    Metres,
    Quantity,
    Radians,
    read_number,
)
from tool0.errors import ConfigError
from tool0.ros1.options import Ros1Options
from tool0.ros2.options import Ros2Options
from tool0.simulation.config import ControlConfig, Names, SimulationConfig
from tool0.ur.options import UrOptions
from tool0.user_data import data_folder


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class EngineOptions:
    """Options of Gazebo."""

    world: Path | None = None
    """World file; the default is an empty world with a ground plane."""
    gazebo_gui: bool = False
    """Open Gazebo's window (gzclient)."""

    def given(self) -> dict[str, object]:
        """Return the given options, under the names that the engine uses."""
        options: dict[str, object] = {}
        if self.world is not None:
            options["world"] = self.world
        if self.gazebo_gui:
            options["gui"] = True
        return options


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class HardwareOptions:
    """Options of a real robot."""

    hardware_port_base: int = 0
    """Offset that is added to a UR's port numbers, to connect to a simulated UR."""
    callback_host: str | None = None
    """Address of this machine as seen from the robot; by default, the local address of
    the connection to the robot."""
    callback_port: int = 0
    """Port on this machine to which tool0's program on the robot connects; 0 selects a
    free port."""
    gripper_link: str | None = None
    """Connection to the gripper: urcap, modbus, modbus:HOST:PORT, rtu:/dev/ttyUSB0 or
    none.  The default is the socket of the URCap."""

    def given(self) -> dict[str, object]:
        """Return the options, under the names that the engine uses."""
        return {
            "port_base": self.hardware_port_base,
            "callback_host": self.callback_host or "",
            "callback_port": self.callback_port,
            "gripper": self.gripper_link or "",
        }


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RunOptions:
    """Duration, output and access."""

    duration: float | None = None
    """Exit after this simulated time [s], counted from when all interfaces are ready.
    By default, the bringup runs until Ctrl-C."""
    headless: bool = False
    """Run without the panel and without any window."""
    summary: bool = True
    """Print a report at the end."""
    as_json: AsJson = False
    """Print the report as one JSON object, and print no other text on standard
    output."""
    name: str = "tool0"
    """Name of this bringup.  Other commands select the bringup by this name: `tool0
    move --name NAME`."""
    panel_folder: Annotated[Path | None, Option(metavar="FOLDER")] = None
    """Also allow the panel to write recordings below this folder.  By default, the
    panel can write only below the user's folders for recordings and episodes."""
    remote: bool = True
    """Allow other processes of this user, such as `tool0 move`, to drive the robot."""
    ros1: bool = False
    """Make the robot available in ROS 1, with the interfaces of ur_gazebo.  `tool0 ros1
    install` installs the required packages."""
    ros2: bool = False
    """Make the robot available in ROS 2, with the interfaces of ur_simulation_gz and
    the controllers of ros2_control.  `tool0 ros2 install` installs the required
    packages."""

    ur: bool = False
    """Emulate a UR control box: RTDE, dashboard server, URScript, and the gripper's
    socket and Modbus interfaces."""

    def __post_init__(self) -> None:
        if self.duration is not None and not 0.0 <= self.duration < math.inf:
            raise ConfigError(
                f"--duration must be 0 or more seconds, got {self.duration}"
            )
        if self.as_json and not self.summary:
            raise ConfigError("--json and --no-summary exclude each other")
        if self.ros1 and self.ros2:
            raise ConfigError(
                "--ros1 and --ros2 exclude each other: the controllers differ"
            )
        for option, is_given in (("--ros2", self.ros2), ("--ur", self.ur)):
            if is_given and not self.remote:
                raise ConfigError(
                    f"{option} needs the socket that --no-remote disables"
                )


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PanelOptions:
    """The panel, a web page that shows and drives the robot."""

    panel_host: str | None = None
    """Address to listen on; 0.0.0.0 selects all addresses.  By default, only browsers
    on this machine can connect.  If other machines can connect, the URL contains a
    token."""
    panel_port: int | None = None
    """Port to listen on.  The default is 8085, or a free port if 8085 is in use."""
    open: bool = True
    """Open the panel in a browser if there is a desktop."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Ros2NodeOptions:
    """ROS 2."""

    ros2_ns: str = ""
    """Namespace of all ROS names, such as robot1, to separate several robots in one
    domain."""
    domain: int | None = None
    """ROS domain ID; the default is the value of the environment variable
    ROS_DOMAIN_ID."""

    def options(self) -> Ros2Options:
        """Return the options in the form that the ROS 2 node requires."""
        return Ros2Options(ns=self.ros2_ns, domain=self.domain)


def _own_programs() -> Path | None:
    """Return the user's folder for UR programs; None if it cannot be created."""
    folder = data_folder() / "ur-programs"
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
    return folder if folder.is_dir() else None


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class UrControllerOptions:
    """The UR controller."""

    ur_host: str = "127.0.0.1"
    """Address to listen on; in a cell, each further arm uses the next address."""
    ur_port_base: int = 0
    """Offset that is added to the port numbers of a real UR."""
    ur_programs: Annotated[Path | None, Option(metavar="FOLDER")] = None
    """Folder with the programs (*.script) that the dashboard server can load; the
    dashboard server also saves its log in this folder.  The default is
    ~/.local/share/tool0/ur-programs."""
    ur_sockets: bool = False
    """Allow URScript programs to connect to other machines."""
    ur_active_gripper: bool = False
    """Start with an activated gripper.  A real gripper must be activated after
    power-on."""

    def options(self) -> UrOptions:
        """Return the options in the form that the UR interface requires."""
        return UrOptions(
            host=self.ur_host,
            port_base=self.ur_port_base,
            programs=self.ur_programs or _own_programs(),
            allow_sockets=self.ur_sockets,
            active_gripper=self.ur_active_gripper,
        )


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class BringupOptions:
    """All options of ``tool0 bringup``, in groups."""

    description: DescriptionConfig = field(default_factory=DescriptionConfig)
    control: ControlConfig = field(default_factory=ControlConfig)
    simulation: SimulationConfig = field(default_factory=SimulationConfig)
    engine: EngineOptions = field(default_factory=EngineOptions)
    hardware: HardwareOptions = field(default_factory=HardwareOptions)
    run: RunOptions = field(default_factory=RunOptions)
    panel: PanelOptions = field(default_factory=PanelOptions)
    ros: Ros1Options = field(default_factory=Ros1Options)
    ros2: Ros2NodeOptions = field(default_factory=Ros2NodeOptions)
    ur: UrControllerOptions = field(default_factory=UrControllerOptions)

    def __post_init__(self) -> None:
        if not self.run.ur and self.ur != UrControllerOptions():
            raise ConfigError(
                "--ur-host, --ur-port-base, --ur-programs, --ur-sockets and "
                "--ur-active-gripper need --ur"
            )
        self.ur.options()  # raises if an option is invalid
        if self.simulation.hardware is None and self.hardware != HardwareOptions():
            raise ConfigError(
                "--hardware-port-base, --callback-host, --callback-port and "
                "--gripper-link need --hardware"
            )
        if self.simulation.hardware is not None:
            self._check_hardware()
        if self.simulation.overwrite and self.simulation.record is None:
            raise ConfigError("--overwrite needs --record")
        if not self.run.ros2 and self.ros2 != Ros2NodeOptions():
            raise ConfigError("--ros2-ns and --domain need --ros2")
        self.ros2.options()  # raises if an option is invalid
        if not self.run.ros1 and self.ros != Ros1Options():
            raise ConfigError(
                "--roscore, --ns, --tf-pub-rate and --camera-rate need --ros1"
            )

    def _check_hardware(self) -> None:
        """Raise ConfigError if an option is given that applies only to a simulation."""
        usual = SimulationConfig()
        simulated = {
            "--engine": self.simulation.engine != usual.engine,
            "--speed": self.simulation.speed != usual.speed,
            "--no-realtime": not self.simulation.realtime,
            "--paused": self.simulation.paused,
            "--grasp-assist": self.simulation.grasp_assist,
            "--world and --gazebo-gui": self.engine != EngineOptions(),
        }
        for option, is_given in simulated.items():
            if is_given:
                raise ConfigError(
                    f"{option}: not with --hardware, which is no simulation"
                )

    def full_description(self) -> DescriptionConfig:
        """Return ``description`` with the tags that the controllers of ROS 2 need.

        A real robot also uses these controllers, because one of them follows the speed
        slider.
        """
        is_ros2 = self.run.ros2 or (
            self.simulation.hardware is not None
            and not self.run.ros1
            and self.description.robot is None
            and self.control.controllers_file is None
        )
        return (
            replace(self.description, ros2_control=True)
            if is_ros2
            else (self.description)
        )

    def full_simulation(self) -> SimulationConfig:
        """Return ``simulation`` with the options of its engine."""
        is_real = self.simulation.hardware is not None
        own = self.hardware.given() if is_real else self.engine.given()
        return replace(self.simulation, engine_options=own)


def _pose(words: list[str]) -> str | dict[str, float]:
    if len(words) == 1 and "=" not in words[0]:
        return words[0]
    return joint_values(words)[0]


def _three(metavar: str, quantity: Quantity) -> Reader:
    return Reader(
        3, metavar, lambda words: tuple(read_number(w, quantity)[0] for w in words)
    )


READERS: Final[Readers] = {
    str | None | Unset: Reader(1, "", lambda words: words[0]),
    Names | None: Reader(1, "'NAME ...'", lambda words: words[0]),
    File | None: Reader(1, "FILE", lambda words: read_path(words[0])),
    Scene | File | None: Reader(1, "FILE", lambda words: read_path(words[0])),
    Cell | File | None: Reader(1, "FILE", lambda words: read_path(words[0])),
    Sequence[str] | None: Reader("*", "NAME=ARM+GRIPPER@X,Y,Z ...", tuple),
    File | Sequence[File] | None: Reader(
        "*", "FILE ...", lambda words: tuple(map(read_path, words))
    ),
    Mapping[str, Argument] | None: Reader(
        "*", "NAME:=VALUE ...", lambda words: assignments(words, ":=")
    ),
    str | Mapping[str, float] | None: Reader("*", "POSE | JOINT=VALUE ...", _pose),
    Sequence[Metres] | None: _three("X Y Z", LENGTH),
    Sequence[Radians] | None: _three("ROLL PITCH YAW", ANGLE),
    tuple[Camera, ...]: None,
    Mapping[str, object]: None,
}
"""Type → notation of configuration values on the command line."""
