"""Request for the hardware components, modeled on ros2_control's controller_manager."""

from __future__ import annotations

from msgspec import Struct

from tool0.description.hardware_component import ComponentType
from tool0.protocol.request import Request


class HardwareInterfaceState(Struct, frozen=True, kw_only=True):
    """A command or state interface."""

    name: str
    """Name of the interface, such as ``elbow_joint/position``."""
    is_available: bool
    """Whether controllers can use the interface."""
    is_claimed: bool
    """Whether a running controller claims the interface."""


class HardwareComponentState(Struct, frozen=True, kw_only=True):
    """A hardware device with a driver, from a ``<ros2_control>`` tag."""

    name: str
    type: ComponentType
    """Type of the component: ``system``, ``actuator`` or ``sensor``."""
    plugin: str
    """Driver plugin in the description; tool0 replaces this plugin."""
    state: str
    """Lifecycle state of the component; simulated hardware is always ``active``."""
    command_interfaces: tuple[HardwareInterfaceState, ...]
    state_interfaces: tuple[HardwareInterfaceState, ...]


class ListHardware(Request[tuple[HardwareComponentState, ...]], frozen=True):
    """List the hardware components with their interfaces.

    A robot with ``<transmission>`` tags is one component.
    """
