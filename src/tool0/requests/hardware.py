"""The request for the hardware components, as ros2_control's controller_manager has."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from msgspec import Struct

from tool0.description.hardware_component import (
    ComponentType,
    HardwareComponent,
    HardwareInterface,
    HardwareItem,
)
from tool0.description.model import RobotModel
from tool0.description.ros2_control import DRIVEN_BY
from tool0.requests.table import Request, handles
from tool0.runtime.simulation import Simulation

_UNSUPPORTED = "acceleration"
"""The interface of a joint that ros2_control knows and no drive follows."""


class HardwareInterfaceState(Struct, frozen=True, kw_only=True):
    """A command or state interface."""

    name: str
    """Such as ``elbow_joint/position``."""
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
    """Its driver in the description, which tool0 replaces."""
    state: str
    """Always ``active``: simulated hardware has no other."""
    command_interfaces: tuple[HardwareInterfaceState, ...]
    state_interfaces: tuple[HardwareInterfaceState, ...]


class ListHardware(Request[tuple[HardwareComponentState, ...]], frozen=True):
    """Every hardware component with its interfaces.

    A robot whose drives are described by ``<transmission>``s is one component.
    """


@handles(ListHardware)
def _list(
    simulation: Simulation, request: ListHardware
) -> tuple[HardwareComponentState, ...]:
    model = simulation.description.model
    claimed = {
        name
        for controller in simulation.snapshot.controllers
        if controller.is_running
        for name in controller.command_interfaces
    }
    components = model.hardware or (_from_transmissions(model),)
    return tuple(
        HardwareComponentState(
            name=component.name,
            type=component.type,
            plugin=component.plugin,
            state="active",
            command_interfaces=tuple(_commands(component, model, claimed)),
            state_interfaces=tuple(_states(component, model)),
        )
        for component in components
    )


def _from_transmissions(model: RobotModel) -> HardwareComponent:
    """Return the drives that transmissions describe as one component."""
    words = {interface: word for word, interface in DRIVEN_BY.items()}
    return HardwareComponent(
        name=model.name,
        type="system",
        plugin="",
        items=tuple(
            HardwareItem(
                kind="joint",
                name=drive.joint,
                commands=_named(words[interface] for interface in drive.interfaces),
                states=_named(DRIVEN_BY),
            )
            for drive in model.transmissions
        ),
    )


def _named(names: Iterable[str]) -> tuple[HardwareInterface, ...]:
    return tuple(HardwareInterface(name=name) for name in names)


def _commands(
    component: HardwareComponent, model: RobotModel, claimed: set[str]
) -> Iterator[HardwareInterfaceState]:
    for item in component.items:
        is_driven = item.name in model.transmission_by_joint
        for command in item.commands:
            moves = item.kind == "joint" and command.name in DRIVEN_BY
            name = f"{item.name}/{command.name}"
            yield HardwareInterfaceState(
                name=name,
                is_available=command.name != _UNSUPPORTED and (is_driven or not moves),
                is_claimed=name in claimed,
            )


def _states(
    component: HardwareComponent, model: RobotModel
) -> Iterator[HardwareInterfaceState]:
    for item in component.items:
        has_place = not item.is_force_torque_sensor or item.name in model.wrench_sensors
        for state in item.states:
            yield HardwareInterfaceState(
                name=f"{item.name}/{state.name}",
                is_available=has_place and state.name != _UNSUPPORTED,
                is_claimed=False,
            )
