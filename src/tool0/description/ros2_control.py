"""Parser of driven joints and their command interfaces in ``<ros2_control>`` tags.

The accepted layout is that of ros2_control's ``component_parser``.  The name of the
driver's plugin is stored but not used, since tool0 replaces the driver. tool0 defines
three joint parameters, which other drivers ignore: ``mechanical_reduction``,
``rotor_inertia`` and ``gravity_compensation``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final, final
from xml.dom.minidom import Element

from tool0.description.hardware_component import (
    HardwareComponent,
    HardwareInterface,
    HardwareItem,
)
from tool0.description.model import (
    Interface,
    Joint,
    JointLimits,
    Mimic,
    Transmission,
)
from tool0.description.ros2_control_elements import (
    check_unique,
    param_number,
    read_component,
)
from tool0.description.xml_source import (
    child_number,
    children,
    choice,
    locate,
    require_known,
    required,
)
from tool0.errors import DescriptionError, LimitsError, ModelError, nearest_name

DRIVEN_BY: Final[Mapping[str, Interface]] = {
    interface.name.lower(): interface for interface in Interface
}
"""Command interfaces that move a joint, by name."""
_MOTION: Final = (*DRIVEN_BY, "acceleration")
"""Names of the interfaces that only joints have."""
_SIMILAR: Final = 0.85
"""Smallest similarity at which a misspelled name, such as ``postion``, is reported as
one of the ``_MOTION`` interfaces."""
_BOOLEANS: Final = ("true", "false")


@final
@dataclass(frozen=True, slots=True)
class Ros2Control:
    """Content of all ``<ros2_control>`` tags of a robot."""

    components: tuple[HardwareComponent, ...]
    drives: Mapping[str, Transmission]
    """Drives of the joints that have command interfaces, by joint name."""
    mimics: Mapping[str, Mimic | None]
    """New mimic relation of each joint with a ``<mimic>`` that is replaced; None if the
    ``<mimic>`` is removed."""
    initial: Mapping[str, float]
    """Start positions by joint name [rad | m]."""


def read_ros2_control(robot: Element, joints: Mapping[str, Joint]) -> Ros2Control:
    """Return the content of the ``<ros2_control>`` tags of ``robot`` for ``joints``.

    Raises:
        DescriptionError: If an element or attribute is missing or cannot be read.
        ModelError: If the tags contradict the joints.
    """
    elements = list(children(robot, "ros2_control"))
    components = tuple(map(read_component, elements))
    check_unique(elements, "component")
    drives: dict[str, Transmission] = {}
    mimics: dict[str, Mimic | None] = {}
    initial: dict[str, float] = {}
    for element, component in zip(elements, components, strict=True):
        reductions = _reductions(element, joints)
        tags = children(element, "joint")
        for tag, item in zip(tags, component.joints, strict=True):
            if _is_other(item, joints):
                continue
            what = f"<ros2_control> '{component.name}' names the unknown joint"
            require_known(item.name, joints, what, locate(tag))
            joint = joints[item.name]
            if (mimic := _mimic(tag, item, joint, joints)) != joint.mimic:
                mimics[item.name] = mimic
            interfaces = _interfaces(tag, item)
            if interfaces and "mimic" not in item.parameters:
                _check_drivable(tag, joint, mimic, drives)
                drive = _drive(tag, component, item, interfaces)
                if "mechanical_reduction" not in item.parameters:
                    reduction = reductions.get(item.name, 1.0)
                    drive = replace(drive, mechanical_reduction=reduction)
                _check_commands(tag, joint, drive.command_limits)
                drives[item.name] = drive
            position = _initial(tag, item, joint)
            if position is not None and mimic is None:
                initial[item.name] = position
    return Ros2Control(components, drives, mimics, initial)


def command_interfaces(robot: Element) -> dict[str, tuple[str, ...]]:
    """Return the command interfaces of each joint, even if the robot is invalid."""
    return {
        joint.getAttribute("name").strip(): tuple(
            interface.getAttribute("name").strip()
            for interface in children(joint, "command_interface")
        )
        for element in children(robot, "ros2_control")
        for joint in children(element, "joint")
    }


def _is_other(item: HardwareItem, joints: Mapping[str, Joint]) -> bool:
    """Return whether a ``<joint>`` tag describes no joint, as for some old drivers."""
    interfaces = (*item.commands, *item.states)
    moves = any(interface.name in _MOTION for interface in interfaces)
    return bool(interfaces) and not moves and item.name not in joints


def _interfaces(element: Element, item: HardwareItem) -> tuple[Interface, ...]:
    """Return the command interfaces that move the joint, in document order."""
    for tag in ("command_interface", "state_interface"):
        for interface in children(element, tag):
            name = required(interface, "name")
            near = nearest_name(name, _MOTION, cutoff=_SIMILAR)
            if name not in _MOTION and near is not None and name.isalpha():
                kind = tag.replace("_", " ")
                raise DescriptionError(
                    f"unknown {kind} '{name}' of joint '{item.name}'; "
                    f"did you mean '{near}'?",
                    locate(interface),
                )
    names = (command.name for command in item.commands)
    return tuple(DRIVEN_BY[name] for name in names if name in DRIVEN_BY)


def _check_drivable(
    element: Element,
    joint: Joint,
    mimic: Mimic | None,
    drives: Mapping[str, Transmission],
) -> None:
    if mimic is not None:
        raise ModelError(
            f"joint '{joint.name}' follows '{mimic.joint}', so it takes no commands; "
            'remove its <command_interface>, or write mimic="false"',
            locate(element),
        )
    if not joint.is_movable:
        raise ModelError(
            f"joint '{joint.name}' is fixed, so it takes no commands; remove its "
            "<command_interface>",
            locate(element),
        )
    other = drives.get(joint.name)
    if other is not None:
        raise ModelError(
            f"joint '{joint.name}' is commanded by two components, '{other.name}' "
            "and this one; remove its <command_interface> from one of them",
            locate(element),
        )


def _mimic(
    element: Element, item: HardwareItem, joint: Joint, joints: Mapping[str, Joint]
) -> Mimic | None:
    """Return the mimic relation of ``joint`` from this tag or from ``<joint>``.

    The attribute ``mimic`` determines whether ``<mimic>`` is kept or removed.  Before
    ROS 2 Jazzy, the mimic relation was stated by parameters.
    """
    if element.hasAttribute("mimic"):
        text = required(element, "mimic").lower()
        if choice(text, _BOOLEANS, element, "boolean") == "false":
            return None
        if joint.mimic is None:
            raise ModelError(
                f"joint '{joint.name}' has mimic=\"true\" here, but no <mimic> where "
                "it is defined; add it there",
                locate(element),
            )
    leader = item.parameters.get("mimic")
    if leader is None:
        return joint.mimic
    what = f"joint '{joint.name}' mimics the unknown joint"
    require_known(leader, joints, what, locate(element))
    own = joint.mimic
    if own is not None and own.joint != leader:
        raise ModelError(
            f"joint '{joint.name}' mimics '{leader}' here, and '{own.joint}' where it "
            "is defined; name one joint",
            locate(element),
        )
    multiplier = _parameter(element, "multiplier", own.multiplier if own else 1.0)
    offset = _parameter(element, "offset", own.offset if own else 0.0)
    return Mimic(joint=leader, multiplier=multiplier, offset=offset)


def _drive(
    element: Element,
    component: HardwareComponent,
    item: HardwareItem,
    interfaces: tuple[Interface, ...],
) -> Transmission:
    reduction = _parameter(element, "mechanical_reduction", 1.0)
    inertia = _parameter(element, "rotor_inertia", 0.0)
    if reduction == 0 or not inertia >= 0:
        raise ModelError(
            f"joint '{item.name}' has mechanical_reduction {reduction:g} and "
            f"rotor_inertia {inertia:g}; the one must not be zero, the other not "
            "negative",
            locate(element),
        )
    compensation = item.parameters.get("gravity_compensation", "false").lower()
    return Transmission(
        name=component.name,
        joint=item.name,
        interfaces=interfaces,
        mechanical_reduction=reduction,
        rotor_inertia=inertia,
        gravity_compensation=choice(compensation, _BOOLEANS, element, "boolean")
        == "true",
        command_limits=_command_limits(item),
    )


def _command_limits(item: HardwareItem) -> JointLimits:
    """Return the limits that are stated in the command interfaces."""
    unlimited = HardwareInterface(name="")
    commands = {command.name: command for command in item.commands}
    position, velocity, effort = (
        commands.get(name, unlimited) for name in ("position", "velocity", "effort")
    )
    return JointLimits(
        lower=position.lower,
        upper=position.upper,
        velocity=_largest(velocity) or math.inf,
        effort=_largest(effort),
    )


def _check_commands(element: Element, joint: Joint, commands: JointLimits) -> None:
    limits = joint.limits
    if not max(limits.lower, commands.lower) <= min(limits.upper, commands.upper):
        raise LimitsError(
            f"joint '{joint.name}' takes positions in [{commands.lower:g}, "
            f"{commands.upper:g}], but its limits are [{limits.lower:g}, "
            f"{limits.upper:g}]",
            locate(element),
        )


def _largest(command: HardwareInterface) -> float:
    """Return the largest magnitude of a command; infinite if there are no limits."""
    bounds = (abs(bound) for bound in (command.lower, command.upper))
    return max(filter(math.isfinite, bounds), default=math.inf)


def _initial(element: Element, item: HardwareItem, joint: Joint) -> float | None:
    """Return the joint's start position, or None if the tag does not state it."""
    for interface in (*item.states, *item.commands):
        if interface.name == "position" and interface.initial is not None:
            position, limits = interface.initial, joint.limits
            if not limits.lower <= position <= limits.upper:
                raise LimitsError(
                    f"joint '{joint.name}' has the initial_value {position:g}, outside "
                    f"of its limits [{limits.lower:g}, {limits.upper:g}]",
                    locate(element),
                )
            return position
    return None


def _parameter(element: Element, name: str, otherwise: float) -> float:
    found = [
        item for item in children(element, "param") if required(item, "name") == name
    ]
    return param_number(found[-1] if found else None, otherwise)


def _reductions(element: Element, joints: Mapping[str, Joint]) -> dict[str, float]:
    """Return the reductions in the nested ``<transmission>`` tags, by joint name."""
    found: dict[str, float] = {}
    for joint in _transmission_joints(element):
        name = required(joint, "name")
        what = "<transmission> names the unknown joint"
        require_known(name, joints, what, locate(joint))
        reduction = child_number(joint, "mechanical_reduction")
        if reduction == 0:
            raise ModelError(
                f"joint '{name}' has the mechanical_reduction 0; it must not be zero",
                locate(joint),
            )
        found[name] = 1.0 if reduction is None else reduction
    return found


def _transmission_joints(element: Element) -> Iterator[Element]:
    for transmission in children(element, "transmission"):
        yield from children(transmission, "joint")
