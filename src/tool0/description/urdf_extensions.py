"""Reading what a simulation needs besides the tree of links and joints.

``<transmission>`` as ros_control reads it, ``<gazebo reference=LINK>`` as Gazebo
does, and ``<parallel_gripper>``, which is our own: other readers of URDF ignore
elements they do not know.
"""

from __future__ import annotations

import logging
from collections.abc import Collection, Mapping
from dataclasses import replace
from xml.dom.minidom import Element

from tool0.description.attributes import (
    child_number,
    choice,
    number,
    only_child,
    positive,
    require_known,
    required,
    required_child,
    text_of,
)
from tool0.description.model import (
    Interface,
    Joint,
    Link,
    ParallelGripper,
    Surface,
    Transmission,
)
from tool0.description.xml_source import children, locate
from tool0.errors import DescriptionError, LimitsError, ModelError, did_you_mean

logger = logging.getLogger(__name__)

_PREFIX = "hardware_interface/"
_BOOLEANS = ("true", "false")


def read_transmissions(
    robot: Element, joints: Collection[str]
) -> tuple[Transmission, ...]:
    """Return the transmissions of ``robot``; each drives one of ``joints``."""
    found: dict[str, Transmission] = {}
    for element in children(robot, "transmission"):
        transmission = _read_transmission(element)
        what = f"transmission '{transmission.name}' drives the unknown joint"
        require_known(transmission.joint, joints, what, locate(element))
        if transmission.joint in found:
            raise ModelError(
                f"joint '{transmission.joint}' has two transmissions, "
                f"'{found[transmission.joint].name}' and '{transmission.name}'; "
                "remove one",
                locate(element),
            )
        found[transmission.joint] = transmission
    return tuple(found.values())


def _read_transmission(element: Element) -> Transmission:
    joint = required_child(element, "joint")
    actuator = only_child(element, "actuator")
    reduction = inertia = None
    carries_weight = False
    if actuator is not None:
        flag = only_child(actuator, "gravityCompensation")
        if flag is not None:
            carries_weight = choice(text_of(flag), _BOOLEANS, flag, "boolean") == "true"
        reduction = child_number(actuator, "mechanicalReduction")
        inertia = child_number(actuator, "rotorInertia")
    if reduction == 0 or (inertia is not None and not inertia >= 0):
        raise ModelError(
            f"<actuator> has reduction {reduction} and rotor inertia {inertia}; "
            "the one must not be zero, the other not negative",
            locate(actuator),
        )
    return Transmission(
        name=required(element, "name"),
        joint=required(joint, "name"),
        interface=_read_interface(element, joint, actuator),
        mechanical_reduction=1.0 if reduction is None else reduction,
        rotor_inertia=0.0 if inertia is None else inertia,
        gravity_compensation=carries_weight,
    )


def _read_interface(
    element: Element, joint: Element, actuator: Element | None
) -> Interface:
    """Return the interface named in ``joint``, else the one in ``actuator``."""
    for owner in (joint, actuator):
        named = [] if owner is None else list(children(owner, "hardwareInterface"))
        if named:
            return to_interface(text_of(named[0]), named[0])
    raise DescriptionError(
        "<transmission> names no <hardwareInterface> in its <joint>; "
        f"give one of {', '.join(item.value for item in Interface)}",
        locate(element),
    )


def to_interface(text: str, element: Element | None = None) -> Interface:
    """Return the interface called ``text``, with or without its package's name."""
    for interface in Interface:
        if text in {interface.value, interface.value.removeprefix(_PREFIX)}:
            return interface
    name = text.rpartition("/")[2]
    valid = [item.value.removeprefix(_PREFIX) for item in Interface]
    if name in valid:
        hint = f"; did you mean '{_PREFIX}{name}'?"
    else:
        hint = did_you_mean(text, [item.value for item in Interface])
    raise DescriptionError(
        f"unknown hardware interface '{text}'{hint}", locate(element)
    )


_SURFACE = ("mu1", "mu2", "kp", "kd", "minDepth", "maxVel")


def apply_gazebo(
    robot: Element, links: dict[str, Link], joints: Collection[str]
) -> dict[str, Link]:
    """Return ``links`` with the surfaces that ``<gazebo reference>`` gives them."""
    changed = dict(links)
    for element in children(robot, "gazebo"):
        reference = element.getAttribute("reference")
        if not reference or reference in joints:
            continue  # for the whole model, or for a joint: Gazebo's own matter
        if reference not in links:
            logger.warning(  # as Gazebo does; published robots have such
                "%s: <gazebo> refers to '%s', which is no link: it has no effect%s",
                locate(element),
                reference,
                did_you_mean(reference, [*links, *joints]),
            )
            continue
        changed[reference] = _with_surface(changed[reference], element)
    return changed


def _with_surface(link: Link, element: Element) -> Link:
    """Return ``link`` with what one ``<gazebo>`` adds; a link may have several."""
    flag = only_child(element, "selfCollide")
    if flag is not None:
        choice(text_of(flag).lower(), ("true", "1", "false", "0"), flag, "boolean")
    values = {tag: child_number(element, tag) for tag in _SURFACE}
    given = {tag: value for tag, value in values.items() if value is not None}
    for tag, value in given.items():
        if not value >= 0:
            raise ModelError(
                f"<{tag}> is {value:g}; it must not be negative", locate(element)
            )
    if not given:
        return link
    before = None if link.surface is None else link.surface.mu1
    return replace(link, surface=Surface(mu1=given.get("mu1", before)))


def read_grippers(
    robot: Element, joints: Mapping[str, Joint]
) -> tuple[ParallelGripper, ...]:
    """Return the grippers of ``robot``; each is driven by one of ``joints``."""
    grippers = []
    for element in children(robot, "parallel_gripper"):
        gripper = _read_gripper(element)
        what = f"gripper '{gripper.name}' is driven by the unknown joint"
        require_known(gripper.joint, joints, what, locate(element))
        passive = tuple(
            (name, joint.mimic)
            for name, joint in joints.items()
            if joint.passive
            and joint.mimic is not None
            and joint.mimic.joint == gripper.joint
        )
        grippers.append(replace(gripper, passive=passive))
    return tuple(grippers)


def _read_gripper(element: Element) -> ParallelGripper:
    speed = (positive(element, "min_speed"), positive(element, "max_speed"))
    force = (positive(element, "min_force"), positive(element, "max_force"))
    if not (speed[0] <= speed[1] and force[0] <= force[1]):
        raise LimitsError(
            f"<parallel_gripper> has speeds {speed} and forces {force}; "
            "the smaller comes first",
            locate(element),
        )
    gripper = ParallelGripper(
        name=required(element, "name"),
        joint=required(element, "joint"),
        pad_offset=number(element, "pad_offset"),
        pad_cos=number(element, "pad_cos"),
        pad_sin=number(element, "pad_sin"),
        max_opening=positive(element, "max_opening"),
        speed=speed,
        force=force,
    )
    for opening in (0.0, gripper.max_opening):
        try:
            gripper.position(opening)
        except (ValueError, ZeroDivisionError):
            raise ModelError(
                f"the linkage of gripper '{gripper.name}' reaches no opening of "
                f"{opening} m; check pad_offset, pad_cos and pad_sin",
                locate(element),
            ) from None
    return gripper
