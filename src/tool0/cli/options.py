"""The options of ``bringup``, ``view`` and ``describe`` as dataclasses.

A field is an option, and the string below it is the option's help.  Which robot, its
controllers and its simulation are the values that ``tool0.bringup`` takes; here are
only the options of the command line itself.  No tyro here: ``parsing.py`` reads most
command lines without it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final, Literal, final

from tool0.cli.parsing import Reader, Readers, assignments, joint_values
from tool0.description.camera import Camera
from tool0.description.config import Argument, DescriptionConfig, File, Unset
from tool0.description.scene import Scene
from tool0.errors import ConfigError
from tool0.interfaces.ros1.options import Ros1Options
from tool0.runtime.config import ControlConfig, Names, SimulationConfig


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class EngineOptions:
    """Options that only one engine has."""

    world: Path | None = None
    """World file for Gazebo; if not given, an empty world with ground."""
    gazebo_gui: bool = False
    """Open Gazebo's own window, gzclient."""

    def given(self) -> dict[str, object]:
        """Return the options that were given, by the engine's own names."""
        options: dict[str, object] = {}
        if self.world is not None:
            options["world"] = self.world
        if self.gazebo_gui:
            options["gui"] = True
        return options


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RunOptions:
    """How long it runs, what it prints, and who can reach it."""

    duration: float | None = None
    """End at this simulated time [s]; otherwise at Ctrl-C."""
    headless: bool = False
    """Do not serve the panel, and open nothing on the desktop."""
    summary: Literal["text", "json", "none"] = "text"
    """What to print at the end; json prints one object and nothing else."""
    name: str = "tool0"
    """The name by which other processes find this bringup."""
    remote: bool = True
    """Let other processes of this user drive the robot: `tool0 move`, …"""
    ros1: bool = False
    """Present the robot in ROS 1 as ur_gazebo does (`tool0 ros1 install`)."""

    def __post_init__(self) -> None:
        if self.duration is not None and not 0.0 <= self.duration < math.inf:
            raise ConfigError(
                f"--duration must be 0 or more seconds, got {self.duration}"
            )


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PanelOptions:
    """The web page that shows and drives the robot."""

    panel_host: str | None = None
    """Address to listen on, 0.0.0.0 for all; if not given, only browsers on this
    machine reach it.  With this or --panel-port, the URL has a token."""
    panel_port: int | None = None
    """Port to listen on; 8085 if not given, or a free one if that is taken."""
    open: bool = True
    """Open the page in a browser, if there is a desktop."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class BringupOptions:
    """Bring up a robot in simulation with its controllers running.

    The robot holds its pose until you command it: from the panel (a web page; its URL
    is printed), from another terminal with `tool0 move`, `tool0 grip` and `tool0
    controllers`, or from Python.
    """

    description: DescriptionConfig = field(default_factory=DescriptionConfig)
    control: ControlConfig = field(default_factory=ControlConfig)
    simulation: SimulationConfig = field(default_factory=SimulationConfig)
    engine: EngineOptions = field(default_factory=EngineOptions)
    run: RunOptions = field(default_factory=RunOptions)
    panel: PanelOptions = field(default_factory=PanelOptions)
    ros: Ros1Options = field(default_factory=Ros1Options)

    def __post_init__(self) -> None:
        if not self.run.ros1 and self.ros != Ros1Options():
            raise ConfigError(
                "--roscore, --ns, --tf-pub-rate and --camera-rate need --ros1"
            )

    def full_simulation(self) -> SimulationConfig:
        """Return ``simulation`` with the options of its engine."""
        return replace(self.simulation, engine_options=self.engine.given())


def _args(words: list[str]) -> Mapping[str, str] | None:
    return assignments(words, ":=", "--args") or None


def _pose(words: list[str]) -> str | dict[str, float] | None:
    if len(words) == 1 and "=" not in words[0]:
        return words[0]
    return joint_values(words, "--initial-pose") or None


READERS: Final[Readers] = {
    str | None | Unset: Reader(1, "NAME", lambda words: words[0]),
    Names | None: Reader(1, "'NAME …'", lambda words: words[0]),
    File | None: Reader(1, "PATH", lambda words: Path(words[0])),
    Scene | File | None: Reader(1, "PATH", lambda words: Path(words[0])),
    File | Sequence[File] | None: Reader(
        "*", "PATH …", lambda words: tuple(map(Path, words)) or None
    ),
    Mapping[str, Argument] | None: Reader("*", "NAME:=VALUE …", _args),
    str | Mapping[str, float] | None: Reader("*", "NAME|JOINT=VALUE …", _pose),
    Sequence[float] | None: Reader(
        3, "FLOAT FLOAT FLOAT", lambda words: tuple(map(float, words))
    ),
    tuple[Camera, ...]: None,
    Mapping[str, object]: None,
}
"""How the types of the configuration values are written on the command line."""
