"""The hardware components of a robot: its ``<ros2_control>`` tags.

A component is one device with a driver: an arm, a gripper.  It offers command and state
interfaces, each of which is one number with a name, such as ``elbow_joint/position``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal, final

ComponentType = Literal["system", "actuator", "sensor"]
ItemKind = Literal["joint", "sensor", "gpio"]

AXES = ("x", "y", "z")
WRENCH = (*(f"force.{axis}" for axis in AXES), *(f"torque.{axis}" for axis in AXES))
"""The state interfaces of a force-torque sensor."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class HardwareInterface:
    """One number that controllers command or read, in SI units."""

    name: str
    """Name such as ``position``."""
    lower: float = -math.inf
    """Smallest command."""
    upper: float = math.inf
    """Largest command."""
    initial: float | None = None
    """Value at the start; None if the description does not say."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class HardwareItem:
    """The interfaces of one joint, sensor or group of inputs and outputs."""

    kind: ItemKind
    name: str
    """Name; for a joint, its name in the URDF."""
    commands: tuple[HardwareInterface, ...] = ()
    states: tuple[HardwareInterface, ...] = ()
    parameters: Mapping[str, str] = field(default_factory=dict)
    """Text of each ``<param>``, by name."""

    @property
    def is_force_torque_sensor(self) -> bool:
        """Whether it is a sensor that measures a wrench."""
        return self.kind == "sensor" and any(
            state.name in WRENCH for state in self.states
        )


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class HardwareComponent:
    """One device with a driver: a ``<ros2_control>`` tag."""

    name: str
    type: ComponentType
    plugin: str
    """The driver, which tool0 replaces: ``gz_ros2_control/GazeboSimSystem``."""
    parameters: Mapping[str, str] = field(default_factory=dict)
    """Text of each ``<param>`` of the driver, by name."""
    items: tuple[HardwareItem, ...] = ()
    """Joints, sensors, inputs and outputs, in the order of the document."""

    @property
    def joints(self) -> Iterator[HardwareItem]:
        """Its joints."""
        return (item for item in self.items if item.kind == "joint")

    @property
    def command_interfaces(self) -> tuple[str, ...]:
        """Full names, such as ``elbow_joint/position``."""
        return tuple(
            f"{item.name}/{interface.name}"
            for item in self.items
            for interface in item.commands
        )

    @property
    def state_interfaces(self) -> tuple[str, ...]:
        """Full names, such as ``tcp_fts_sensor/force.x``."""
        return tuple(
            f"{item.name}/{interface.name}"
            for item in self.items
            for interface in item.states
        )
