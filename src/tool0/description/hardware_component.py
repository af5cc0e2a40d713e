"""The hardware components of a robot: its ``<ros2_control>`` tags.

A component is one device with a driver, such as an arm or a gripper.  It offers command
and state interfaces: named numbers such as ``elbow_joint/position``.
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
"""State interfaces of a force-torque sensor."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class HardwareInterface:
    """Interface of one number that controllers command or read, in SI units."""

    name: str
    """Name such as ``position``."""
    lower: float = -math.inf
    """Smallest command [SI]."""
    upper: float = math.inf
    """Largest command [SI]."""
    initial: float | None = None
    """Initial value; None if the description does not state one."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class HardwareItem:
    """The interfaces of one joint, sensor or group of inputs and outputs."""

    kind: ItemKind
    name: str
    """Name of the item; for a joint, its name in the URDF."""
    commands: tuple[HardwareInterface, ...] = ()
    states: tuple[HardwareInterface, ...] = ()
    parameters: Mapping[str, str] = field(default_factory=dict)
    """Text of each ``<param>`` of the item, by name."""

    @property
    def is_force_torque_sensor(self) -> bool:
        """Whether the item is a sensor that measures a wrench."""
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
    """Name of the driver (tool0 replaces it), such as
    ``gz_ros2_control/GazeboSimSystem``."""
    parameters: Mapping[str, str] = field(default_factory=dict)
    """Text of each ``<param>`` of the driver, by name."""
    items: tuple[HardwareItem, ...] = ()
    """Joints, sensors, inputs and outputs, in document order."""

    @property
    def joints(self) -> Iterator[HardwareItem]:
        """The joints of the component."""
        return (item for item in self.items if item.kind == "joint")

    @property
    def command_interfaces(self) -> tuple[str, ...]:
        """Full names of the command interfaces, such as ``elbow_joint/position``."""
        return tuple(
            f"{item.name}/{interface.name}"
            for item in self.items
            for interface in item.commands
        )

    @property
    def state_interfaces(self) -> tuple[str, ...]:
        """Full names of the state interfaces, such as ``tcp_fts_sensor/force.x``."""
        return tuple(
            f"{item.name}/{interface.name}"
            for item in self.items
            for interface in item.states
        )
