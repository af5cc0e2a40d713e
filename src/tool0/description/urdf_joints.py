"""Reading ``<joint>`` and what ties joints together: mimics, springs and loops.

``<loop_joint>`` and ``<passive_joint>`` are our own (the latter is called so in SRDF);
``<springStiffness>`` and ``<springReference>`` are Gazebo's.  Other readers of URDF
ignore all of them.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from xml.dom.minidom import Element

from tool0.description.attributes import (
    child_number,
    choice,
    number,
    only_child,
    origin,
    require_known,
    required,
    required_child,
    vector,
)
from tool0.description.forward_kinematics import link_poses
from tool0.description.model import (
    Joint,
    JointLimits,
    JointType,
    LoopJoint,
    Mimic,
    RobotModel,
    SafetyController,
    Spring,
)
from tool0.description.transform import Vector3
from tool0.description.xml_source import children, locate
from tool0.errors import (
    DescriptionError,
    LimitsError,
    ModelError,
    SourceLocation,
)

LOOP_GAP = 1e-5
"""How far apart the two ends of a loop may lie in its rest position [m]."""

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
        what = f"joint '{joint.name}' mimics the unknown joint"
        require_known(joint.mimic.joint, joints, what, location)
        leader = joints[joint.mimic.joint]
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


def apply_springs(robot: Element, joints: Mapping[str, Joint]) -> dict[str, Joint]:
    """Return ``joints`` with the springs that ``<gazebo reference>`` gives them."""
    changed = dict(joints)
    for element in children(robot, "gazebo"):
        name = element.getAttribute("reference")
        stiffness = child_number(element, "springStiffness")
        if name not in joints or stiffness is None:
            continue
        if not stiffness >= 0:
            raise ModelError(
                f"<springStiffness> of joint '{name}' is {stiffness:g}; "
                "it must not be negative",
                locate(element),
            )
        reference = child_number(element, "springReference") or 0.0
        spring = Spring(stiffness=stiffness, reference=reference)
        changed[name] = replace(changed[name], spring=spring)
    return changed


def mark_passive(robot: Element, joints: Mapping[str, Joint]) -> dict[str, Joint]:
    """Return ``joints`` with those marked that only a loop holds."""
    changed = dict(joints)
    for element in children(robot, "passive_joint"):
        name = required(element, "name")
        what = "<passive_joint> names the unknown joint"
        require_known(name, joints, what, locate(element))
        if joints[name].mimic is None:
            raise ModelError(
                f"passive joint '{name}' lacks <mimic>, which gives its rest position",
                locate(element),
            )
        changed[name] = replace(changed[name], passive=True)
    return changed


def read_loops(robot: Element, links: Collection[str]) -> tuple[LoopJoint, ...]:
    """Return the joints that close loops between ``links``."""
    return tuple(_read_loop(item, links) for item in children(robot, "loop_joint"))


def _read_loop(element: Element, links: Collection[str]) -> LoopJoint:
    name = required(element, "name")
    ends = list(children(element, "end"))
    if len(ends) != 2:
        raise DescriptionError(
            f"<loop_joint> '{name}' has {len(ends)} <end>; give two, "
            'as <end link="…" xyz="…"/>',
            locate(element),
        )
    first, second = (required(end, "link") for end in ends)
    for link, end in zip((first, second), ends, strict=True):
        what = f"<loop_joint> '{name}' ends at the unknown link"
        require_known(link, links, what, locate(end))
    if first == second:
        raise ModelError(
            f"<loop_joint> '{name}' joins '{first}' to itself; name two links",
            locate(element),
        )
    return LoopJoint(
        name=name,
        links=(first, second),
        points=(vector(ends[0], "xyz"), vector(ends[1], "xyz")),
    )


def check_loops(model: RobotModel) -> None:
    """Raise ModelError unless every loop is closed in every rest position.

    The ``<mimic>`` of passive joints must keep the loop closed; both ends and the
    middle of each master's range are tried.
    """
    if not model.loops:
        return
    masters = [model.joint(name) for name in _masters(model)]
    for share in (0.0, 0.5, 1.0):
        position = {
            joint.name: joint.limits.lower
            + share * (joint.limits.upper - joint.limits.lower)
            for joint in masters
            if math.isfinite(joint.limits.upper - joint.limits.lower)
        }
        frames = link_poses(model, position)
        for loop in model.loops:
            first, second = (
                frames[link].apply(point)
                for link, point in zip(loop.links, loop.points, strict=True)
            )
            gap = math.dist(first, second)
            if not gap <= LOOP_GAP:
                raise ModelError(
                    f"loop '{loop.name}' does not close: its ends on "
                    f"'{loop.links[0]}' and '{loop.links[1]}' are "
                    f"{1000 * gap:.3f} mm apart at {position}; "
                    "check its points and the <mimic> of its joints"
                )


def _masters(model: RobotModel) -> list[str]:
    """Return the joints that passive ones follow."""
    return sorted(
        {joint.mimic.joint for joint in model.joints if joint.passive and joint.mimic}
    )
