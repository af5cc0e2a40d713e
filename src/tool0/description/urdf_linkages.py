"""Reading what makes a linkage of a tree: loops, passive joints and springs.

``<loop_joint>`` and ``<passive_joint>`` are our own (the latter is called so in SRDF);
``<springStiffness>`` and ``<springReference>`` are Gazebo's.  Other readers of URDF
ignore all of them.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from xml.dom.minidom import Element

from tool0.description.attributes import child_number, required, vector
from tool0.description.kinematics import transforms
from tool0.description.model import Joint, LoopJoint, RobotModel, Spring
from tool0.description.xml_source import children, locate
from tool0.errors import DescriptionError, ModelError, did_you_mean

GAP = 1e-5
"""How far apart the two ends of a loop may lie where it rests [m]."""


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
    """Return ``joints`` with those marked that nothing but a loop holds."""
    changed = dict(joints)
    for element in children(robot, "passive_joint"):
        name = required(element, "name")
        if name not in joints:
            hint = did_you_mean(name, list(joints))
            raise ModelError(
                f"<passive_joint> names the unknown joint '{name}'{hint}",
                locate(element),
            )
        if joints[name].mimic is None:
            raise ModelError(
                f"passive joint '{name}' lacks <mimic>, which says where it rests",
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
        if link not in links:
            hint = did_you_mean(link, list(links))
            raise ModelError(
                f"<loop_joint> '{name}' ends at the unknown link '{link}'{hint}",
                locate(end),
            )
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
    """Raise ModelError unless every loop is closed wherever its joints rest.

    What ``<mimic>`` says of passive joints must keep the loop closed; both ends and
    the middle of each master's range are tried.
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
        frames = transforms(model, position)
        for loop in model.loops:
            first, second = (
                frames[link].apply(point)
                for link, point in zip(loop.links, loop.points, strict=True)
            )
            gap = math.dist(first, second)
            if not gap <= GAP:
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
