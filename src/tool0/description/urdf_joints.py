"""Reading ``<joint>``: frames, axis, limits, mimic and safety."""

from __future__ import annotations

import math
from collections.abc import Mapping
from xml.dom.minidom import Element

from tool0.description.attributes import (
    choice,
    number,
    only_child,
    origin,
    required,
    required_child,
    vector,
)
from tool0.description.model import (
    Joint,
    JointLimits,
    JointType,
    Mimic,
    SafetyController,
    Vector3,
)
from tool0.description.xml_source import locate
from tool0.errors import LimitsError, ModelError, SourceLocation, did_you_mean

_LIMITED = (JointType.REVOLUTE, JointType.PRISMATIC)
_WITH_AXIS = (*_LIMITED, JointType.CONTINUOUS, JointType.PLANAR)


def read_joint(element: Element) -> Joint:
    """Return the joint that ``element`` describes."""
    name = required(element, "name")
    valid = [kind.value for kind in JointType]
    kind = JointType(choice(required(element, "type"), valid, element, "joint type"))
    dynamics = only_child(element, "dynamics")
    return Joint(
        name=name,
        type=kind,
        parent=required(required_child(element, "parent"), "link"),
        child=required(required_child(element, "child"), "link"),
        origin=origin(element),
        axis=_read_axis(element, name) if kind in _WITH_AXIS else (1.0, 0.0, 0.0),
        limits=_read_limits(element, name, kind),
        damping=0.0 if dynamics is None else _not_negative(dynamics, "damping"),
        friction=0.0 if dynamics is None else _not_negative(dynamics, "friction"),
        mimic=_read_mimic(element),
        safety=_read_safety(element),
    )


def _read_axis(element: Element, name: str) -> Vector3:
    child = only_child(element, "axis")
    if child is None:
        return (1.0, 0.0, 0.0)  # URDF's default
    x, y, z = vector(child, "xyz")
    length = math.sqrt(x * x + y * y + z * z)
    if not length > 1e-9:
        raise ModelError(
            f"joint '{name}' has a zero axis; give a direction such as 0 0 1",
            locate(child),
        )
    return (x / length, y / length, z / length)


def _read_limits(element: Element, name: str, kind: JointType) -> JointLimits:
    child = only_child(element, "limit")
    if child is None:
        if kind in _LIMITED:
            raise LimitsError(
                f"{kind.value} joint '{name}' lacks "
                '<limit lower="…" upper="…" effort="…" velocity="…"/>; '
                "a joint that turns without end is of type continuous",
                locate(element),
            )
        return JointLimits()
    unlimited = -1.0  # urdfdom requires both; a joint without end may leave them out
    velocity = number(child, "velocity", None if kind in _LIMITED else unlimited)
    effort = number(child, "effort", None if kind in _LIMITED else unlimited)
    try:
        return JointLimits(
            lower=number(child, "lower", 0.0) if kind in _LIMITED else -math.inf,
            upper=number(child, "upper", 0.0) if kind in _LIMITED else math.inf,
            velocity=math.inf if not child.hasAttribute("velocity") else velocity,
            effort=math.inf if not child.hasAttribute("effort") else effort,
        )
    except LimitsError as error:
        raise LimitsError(f"joint '{name}': {error.message}", locate(child)) from None


def _not_negative(element: Element, attribute: str) -> float:
    value = number(element, attribute, 0.0)
    if not value >= 0:
        raise ModelError(
            f"<{element.tagName}> has {attribute} {value:g}; it must not be negative",
            locate(element),
        )
    return value


def _read_mimic(element: Element) -> Mimic | None:
    child = only_child(element, "mimic")
    if child is None:
        return None
    return Mimic(
        joint=required(child, "joint"),
        multiplier=number(child, "multiplier", 1.0),
        offset=number(child, "offset", 0.0),
    )


def _read_safety(element: Element) -> SafetyController | None:
    child = only_child(element, "safety_controller")
    if child is None:
        return None
    soft = {
        f"soft_{side}": number(child, f"soft_{side}")
        for side in ("lower_limit", "upper_limit")
        if child.hasAttribute(f"soft_{side}")
    }
    safety = SafetyController(
        **soft,
        k_position=number(child, "k_position", 0.0),
        k_velocity=number(child, "k_velocity", 0.0),
    )
    if not safety.soft_lower_limit <= safety.soft_upper_limit:
        raise LimitsError(
            f"soft lower limit {safety.soft_lower_limit} is above "
            f"soft upper limit {safety.soft_upper_limit}; take a smaller margin",
            locate(child),
        )
    return safety


def check_mimics(
    joints: Mapping[str, Joint], locations: Mapping[str, SourceLocation]
) -> None:
    """Raise ModelError unless each mimic joint follows one that follows none."""
    for joint in joints.values():
        if joint.mimic is None:
            continue
        location = locations.get(f"joint:{joint.name}")
        leader = joints.get(joint.mimic.joint)
        if leader is None:
            hint = did_you_mean(joint.mimic.joint, list(joints))
            raise ModelError(
                f"joint '{joint.name}' mimics the unknown joint "
                f"'{joint.mimic.joint}'{hint}",
                location,
            )
        if leader is joint or leader.mimic is not None:
            raise ModelError(
                f"joint '{joint.name}' mimics '{leader.name}', which mimics "
                f"'{leader.mimic.joint if leader.mimic else leader.name}'; "
                "name the joint at the end of the chain, which must mimic none",
                location,
            )
        if not (leader.is_movable and joint.is_movable):
            raise ModelError(
                f"joint '{joint.name}' mimics '{leader.name}', but a fixed joint "
                "can neither follow nor lead; remove <mimic>",
                location,
            )
