"""Hardware components of a robot, which are described by ``<ros2_control>`` tags.

A component is one device with a driver, such as an arm or a gripper.  A component
provides command and state interfaces, which are named numbers such as
``elbow_joint/position``.
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
    """Interface for one number, in SI units, that controllers command or read."""

    name: str
    """Name of the interface, such as ``position``."""
    lower: float = -math.inf
    """Smallest command [SI unit]."""
    upper: float = math.inf
    """Largest command [SI unit]."""
    initial: float | None = None
    """Initial value; None if the description does not state an initial value."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class HardwareItem:
    """The interfaces of one joint, sensor or group of inputs and outputs."""

    kind: ItemKind
    name: str
    """Name of the item.  The name of a joint is its name in the URDF."""
    commands: tuple[HardwareInterface, ...] = ()
    states: tuple[HardwareInterface, ...] = ()
    parameters: Mapping[str, str] = field(default_factory=dict)
    """Text of each ``<param>`` element of the item, by parameter name."""

    @property
    def is_force_torque_sensor(self) -> bool:
        """Whether the item is a sensor that measures a wrench."""
        return self.kind == "sensor" and any(
            state.name in WRENCH for state in self.states
        )


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class HardwareComponent:
    """One device with a driver, which is described by a ``<ros2_control>`` tag."""

    name: str
    type: ComponentType
    plugin: str
    """Plugin name of the driver, such as ``gz_ros2_control/GazeboSimSystem``. tool0
    replaces this driver."""
    parameters: Mapping[str, str] = field(default_factory=dict)
    """Text of each ``<param>`` element of the driver, by parameter name."""
    items: tuple[HardwareItem, ...] = ()
    """Joints, sensors, inputs and outputs of the component, in document order."""

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
