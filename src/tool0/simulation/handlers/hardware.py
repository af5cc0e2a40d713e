"""Handler of the request that lists the hardware components."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from tool0.description.hardware_component import (
    HardwareComponent,
    HardwareInterface,
    HardwareItem,
)
from tool0.description.model import RobotModel
from tool0.description.ros2_control import DRIVEN_BY
from tool0.protocol.hardware import (
    HardwareComponentState,
    HardwareInterfaceState,
    ListHardware,
)
from tool0.simulation.handlers.table import handles
from tool0.simulation.simulation import Simulation

_UNSUPPORTED = "acceleration"
"""A joint interface of ros2_control that no drive supports."""


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
    """Return one component with the drives that the transmissions describe."""
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
