"""Parser of the components and interfaces in ``<ros2_control>`` elements."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final, get_args
from xml.dom.minidom import Element

from tool0.description.hardware_component import (
    ComponentType,
    HardwareComponent,
    HardwareInterface,
    HardwareItem,
    ItemKind,
)
from tool0.description.xml_source import (
    children,
    choice,
    locate,
    required,
    required_child,
    text_of,
    to_numbers,
)
from tool0.errors import LimitsError, ModelError

_ACTIVATION: Final = "reactivate_gripper_cmd"
"""Command interface by which a gripper with a separate driver is identified."""
_GRIP_LIMITS: Final = ("set_gripper_max_velocity", "set_gripper_max_effort")
"""Command interfaces that the driver of such a gripper provides for the gripper's
joint, even if the description does not list them."""


def read_component(element: Element) -> HardwareComponent:
    """Return the component that ``element`` describes."""
    name = required(element, "name")
    types = get_args(ComponentType)
    kind = choice(required(element, "type"), types, element, "type of <ros2_control>")
    hardware = required_child(element, "hardware")
    plugin = text_of(required_child(hardware, "plugin"))
    items = [
        _read_item(child)
        for child in children(element)
        if child.tagName in get_args(ItemKind)
    ]
    for tag in get_args(ItemKind):
        check_unique(list(children(element, tag)), tag)
    if any(_ACTIVATION in (each.name for each in item.commands) for item in items):
        items = list(map(_with_grip_limits, items))
    return HardwareComponent(
        name=name,
        type=kind,  # type: ignore[arg-type]  # one of the choices
        plugin=plugin,
        parameters=_parameters(hardware),
        items=tuple(items),
    )


def _read_item(element: Element) -> HardwareItem:
    commands = list(children(element, "command_interface"))
    states = list(children(element, "state_interface"))
    check_unique(commands, "command interface")
    check_unique(states, "state interface")
    return HardwareItem(
        kind=element.tagName,  # type: ignore[arg-type]  # one of the choices
        name=required(element, "name"),
        commands=tuple(map(_read_interface, commands)),
        states=tuple(map(_read_interface, states)),
        parameters=_parameters(element),
    )


def _with_grip_limits(item: HardwareItem) -> HardwareItem:
    """Return a gripper's joint with the command interfaces added by its driver."""
    names = {command.name for command in item.commands}
    if item.kind != "joint" or not names:
        return item
    added = (HardwareInterface(name=name) for name in _GRIP_LIMITS if name not in names)
    return replace(item, commands=(*item.commands, *added))


def _read_interface(element: Element) -> HardwareInterface:
    parameters = {required(item, "name"): item for item in children(element, "param")}
    lower = param_number(parameters.get("min"), -math.inf)
    upper = param_number(parameters.get("max"), math.inf)
    if not lower <= upper:
        raise LimitsError(
            f"<{element.tagName}> has min {lower:g} above max {upper:g}",
            locate(element),
        )
    initial = parameters.get("initial_value")
    return HardwareInterface(
        name=required(element, "name"),
        lower=lower,
        upper=upper,
        initial=None if initial is None else param_number(initial, 0.0),
    )


def _parameters(element: Element) -> dict[str, str]:
    return {
        required(item, "name"): text_of(item) for item in children(element, "param")
    }


def param_number(element: Element | None, otherwise: float) -> float:
    """Return the number in a ``<param>``."""
    if element is None:
        return otherwise
    what = required(element, "name")
    return to_numbers(text_of(element), 1, element, what)[0]


def check_unique(elements: Sequence[Element], what: str) -> None:
    """Raise ModelError if two ``elements`` have the same name."""
    seen: set[str] = set()
    for element in elements:
        name = required(element, "name")
        if name in seen:
            raise ModelError(
                f"a second {what} '{name}'; rename or remove one", locate(element)
            )
        seen.add(name)
