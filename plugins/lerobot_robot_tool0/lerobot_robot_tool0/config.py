"""The options ``--robot.…`` and ``--teleop.…``."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final, Literal

from lerobot.robots import RobotConfig
from lerobot.teleoperators import TeleoperatorConfig

from tool0.errors import ConfigError

_RANGES: Final = {"speed": (0.005, 0.25), "turn_speed": (0.02, 1.0)}
"""Those of the panel's jogging [m/s, rad/s]."""


@RobotConfig.register_subclass("tool0")
@dataclass(kw_only=True)
class Tool0RobotConfig(RobotConfig):
    """A running bring-up."""

    bringup: str = "tool0"
    """Its name: ``tool0 bringup --name NAME``."""
    fps: int = 30
    """Actions per second [Hz]; those of the program."""
    camera_names: list[str] = field(default_factory=list)
    """Cameras of the bring-up whose images are observed."""


@TeleoperatorConfig.register_subclass("tool0_leader")
@dataclass(kw_only=True)
class Tool0LeaderConfig(TeleoperatorConfig):
    """Another bring-up of the same kind of robot, whose joints are followed.

    It is a real arm that is guided by hand, or a simulated one that is moved by its
    panel, from a phone too.
    """

    bringup: str = "leader"
    """Its name: ``tool0 bringup --name NAME``."""


@dataclass(kw_only=True)
class ToolTeleopConfig(TeleoperatorConfig):
    """A device that moves the tool of the robot's bring-up."""

    bringup: str = "tool0"
    """Name of the bring-up that is moved: that of the robot."""
    arm: str = ""
    """Name of the arm that is moved; empty for the only one."""
    frame: Literal["root", "tool"] = "root"
    """Axes of the motion: those of the robot's root, or of the flange."""
    speed: float = 0.1
    """Largest speed of the flange [m/s], 0.005 … 0.25."""
    turn_speed: float = 0.4
    """Largest speed of its rotation [rad/s], 0.02 … 1."""
    dead_zone: float = 0.12
    """Deflection that counts as none, part of the largest one, 0 … 0.9."""

    def __post_init__(self) -> None:
        """Check the ranges, or raise ConfigError."""
        for name, (low, high) in {**_RANGES, "dead_zone": (0.0, 0.9)}.items():
            value = getattr(self, name)
            if not (math.isfinite(value) and low <= value <= high):
                raise ConfigError(f"{name} must be {low:g} … {high:g}, got {value:g}")
        if self.frame not in ("root", "tool"):
            raise ConfigError(f"frame must be root or tool, got '{self.frame}'")


@TeleoperatorConfig.register_subclass("tool0_gamepad")
@dataclass(kw_only=True)
class Tool0GamepadConfig(ToolTeleopConfig):
    """A gamepad whose layout SDL knows."""

    device: str = ""
    """Part of its name, if there are several."""


@TeleoperatorConfig.register_subclass("tool0_spacemouse")
@dataclass(kw_only=True)
class Tool0SpaceMouseConfig(ToolTeleopConfig):
    """A SpaceMouse of 3Dconnexion."""

    dead_zone: float = 0.08
