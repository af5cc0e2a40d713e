"""The request for the hardware components, as ros2_control's controller_manager has."""

from __future__ import annotations

from msgspec import Struct

from tool0.description.hardware_component import ComponentType
from tool0.protocol.request import Request


class HardwareInterfaceState(Struct, frozen=True, kw_only=True):
    """A command or state interface."""

    name: str
    """Name such as ``elbow_joint/position``."""
    is_available: bool
    """Whether controllers can use it."""
    is_claimed: bool
    """Whether a running controller commands through it."""


class HardwareComponentState(Struct, frozen=True, kw_only=True):
    """One device with a driver: a ``<ros2_control>`` tag."""

    name: str
    type: ComponentType
    """``system``, ``actuator`` or ``sensor``."""
    plugin: str
    """Driver in the description, which tool0 replaces."""
    state: str
    """Always ``active``: simulated hardware has no other."""
    command_interfaces: tuple[HardwareInterfaceState, ...]
    state_interfaces: tuple[HardwareInterfaceState, ...]


class ListHardware(Request[tuple[HardwareComponentState, ...]], frozen=True):
    """Every hardware component with its interfaces.

    A robot whose drives are described by ``<transmission>``s is one component.
    """
