"""The options ``--robot.…`` and ``--teleop.…``."""

from __future__ import annotations

from dataclasses import dataclass, field

from lerobot.robots import RobotConfig
from lerobot.teleoperators import TeleoperatorConfig


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
