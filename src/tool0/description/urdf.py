"""Strict URDF parser, which returns a ``RobotModel`` or an error with file and line.

In addition to the tree, the parser reads ``<transmission>`` as ros_control does,
``<ros2_control>`` as ros2_control does, and ``<gazebo reference=…>`` (surfaces and
springs) as Gazebo does.  The parser also reads the elements that tool0 defines:
``<loop_joint>``, ``<passive_joint>`` (a name from SRDF), ``<parallel_gripper>`` and
``<self_collide>``.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TypeVar
from xml.dom.minidom import Document, Element

from tool0.description.finding import quoted
from tool0.description.forward_kinematics import link_poses
from tool0.description.model import (
    Joint,
    Link,
    RobotModel,
    Spring,
    Surface,
    Transmission,
)
from tool0.description.ros2_control import read_ros2_control
from tool0.description.urdf_elements import (
    read_color,
    read_gripper,
    read_joint,
    read_link,
    read_loop,
    read_transmission,
)
from tool0.description.xml_source import (
    child_number,
    children,
    choice,
    locate,
    not_negative,
    require_known,
    required,
    text_of,
)
from tool0.errors import DescriptionError, ModelError, SourceLocation, did_you_mean

logger = logging.getLogger(__name__)

Item = TypeVar("Item", Link, Joint)
_Locations = dict[str, SourceLocation]

LOOP_GAP = 1e-5
"""Largest distance between the ends of a loop in its rest position [m]."""
_SELF_COLLIDE = ("selfCollide", "self_collide")
"""Tags from which libsdformat determines whether a link collides with other links of
the same model."""
_BOOLEANS = ("true", "1", "false", "0")
_SURFACE = ("mu1", "mu2", "kp", "kd", "minDepth", "maxVel")


def read_model(document: Document) -> RobotModel:
    """Return the robot that ``document`` describes.

    Unknown elements are ignored, as they are in ROS.

    Raises:
        DescriptionError: If an element or attribute is missing or cannot be read.
        ModelError: If a parameter of the robot is physically impossible.
    """
    robot = document.documentElement
    if robot is None or robot.tagName != "robot":
        tag = "nothing" if robot is None else f"<{robot.tagName}>"
        raise DescriptionError(
            f"the document holds {tag}; a URDF holds <robot>", locate(robot)
        )
    locations: _Locations = {}
    materials = {
        required(element, "name"): rgba
        for element in children(robot, "material")
        if (rgba := read_color(element)) is not None
    }
    links: dict[str, Link] = {}
    for element in children(robot, "link"):
        _add(links, "link", read_link(element, materials), element, locations)
    joints: dict[str, Joint] = {}
    for element in children(robot, "joint"):
        _add(joints, "joint", read_joint(element), element, locations)
    if not links:
        raise ModelError("the robot has no <link>; give it at least one", locate(robot))
    control = read_ros2_control(robot, joints)
    for name, mimic in control.mimics.items():
        joints[name] = replace(joints[name], mimic=mimic)
    _check_mimics(joints, locations)
    _apply_gazebo(robot, links, joints)
    _mark_passive(robot, joints)
    root, ordered = _order(links, joints, locations)
    model = RobotModel(
        name=required(robot, "name"),
        root=root,
        links=tuple(links.values()),
        joints=ordered,
        transmissions=_read_transmissions(robot, joints, control.drives),
        grippers=tuple(
            read_gripper(item, joints) for item in children(robot, "parallel_gripper")
        ),
        loops=tuple(read_loop(item, links) for item in children(robot, "loop_joint")),
        self_collide=_is_self_colliding(robot),
        hardware=control.components,
        initial_positions=control.initial,
        locations=locations,
    )
    _check_loops(model)
    return model


def _add(
    items: dict[str, Item],
    kind: str,
    item: Item,
    element: Element,
    locations: _Locations,
) -> None:
    location = locate(element)
    key = f"{kind}:{item.name}"
    if item.name in items:
        raise ModelError(
            f"a second {kind} '{item.name}'; the first is at {locations.get(key)}. "
            "Rename one, or give each robot its own prefix",
            location,
        )
    items[item.name] = item
    if location is not None:
        locations[key] = location


def _order(
    links: Mapping[str, Link], joints: Mapping[str, Joint], locations: _Locations
) -> tuple[str, tuple[Joint, ...]]:
    """Return the root link and the joints in depth-first order, or raise ModelError."""
    above: dict[str, Joint] = {}
    below: dict[str, list[Joint]] = {name: [] for name in links}
    for joint in joints.values():
        location = locations.get(f"joint:{joint.name}")
        for role, name in (("parent", joint.parent), ("child", joint.child)):
            what = f"joint '{joint.name}' has the unknown {role} link"
            require_known(name, links, what, location)
        if joint.child in above:
            raise ModelError(
                f"link '{joint.child}' has two parents, by the joints "
                f"'{above[joint.child].name}' and '{joint.name}'; URDF is a tree: "
                "remove one joint",
                location,
            )
        above[joint.child] = joint
        below[joint.parent].append(joint)
    roots = [name for name in links if name not in above]
    if len(roots) > 1:
        raise ModelError(
            f"the links are not connected: no joint leads to {quoted(roots)}; "
            "join all but one of them to the rest",
            locations.get(f"link:{roots[1]}"),
        )
    ordered: dict[str, Joint] = {}
    waiting = below[roots[0]][::-1] if roots else []
    while waiting:
        joint = waiting.pop()
        ordered[joint.name] = joint
        waiting.extend(reversed(below[joint.child]))
    for joint in joints.values():
        if joint.name not in ordered:
            loop = _loop(above, joint)
            raise ModelError(
                f"the joints {quoted(loop)} form a loop; URDF is a tree: remove one",
                locations.get(f"joint:{loop[0]}"),
            )
    return roots[0], tuple(ordered.values())


def _loop(above: Mapping[str, Joint], start: Joint) -> list[str]:
    """Return the joints of the cycle that is found upwards from ``start``."""
    path: list[str] = []
    joint = start
    while joint.name not in path:
        path.append(joint.name)
        joint = above[joint.parent]
    return list(reversed(path[path.index(joint.name) :]))


def _check_mimics(joints: Mapping[str, Joint], locations: _Locations) -> None:
    """Raise ModelError if a mimic joint follows an unknown joint or a mimic joint."""
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
                "mimic the joint at the end of the chain instead; that joint must not "
                "mimic another",
                location,
            )
        if not (leader.is_movable and joint.is_movable):
            raise ModelError(
                f"joint '{joint.name}' mimics '{leader.name}', but a fixed joint "
                "can neither follow nor lead; remove <mimic>",
                location,
            )


def _apply_gazebo(
    robot: Element, links: dict[str, Link], joints: dict[str, Joint]
) -> None:
    """Add the springs and surfaces in ``<gazebo reference>`` to joints and links."""
    for element in children(robot, "gazebo"):
        name = element.getAttribute("reference")
        if name in joints:
            joints[name] = _with_spring(joints[name], element)
        elif name in links:
            links[name] = _with_surface(links[name], element)
        elif name:
            # Only Gazebo uses an element without a name.  A reference to an unknown
            # name causes only a warning, as in Gazebo, since published robots contain
            # such references.
            logger.warning(
                "%s: <gazebo> refers to '%s', which is no link: it has no effect%s",
                locate(element),
                name,
                did_you_mean(name, [*links, *joints]),
            )


def _with_spring(joint: Joint, element: Element) -> Joint:
    stiffness = child_number(element, "springStiffness")
    if stiffness is None:
        return joint
    not_negative(stiffness, f"<springStiffness> of joint '{joint.name}' is", element)
    reference = child_number(element, "springReference") or 0.0
    return replace(joint, spring=Spring(stiffness=stiffness, reference=reference))


def _with_surface(link: Link, element: Element) -> Link:
    """Return ``link`` with the properties in one of its ``<gazebo>`` elements."""
    flags = [flag for tag in _SELF_COLLIDE for flag in children(element, tag)]
    if flags:
        link = replace(link, self_collide=any([_is_true(flag) for flag in flags]))
    values = {tag: child_number(element, tag) for tag in _SURFACE}
    given = {
        tag: not_negative(value, f"<{tag}> is", element)
        for tag, value in values.items()
        if value is not None
    }
    if not given:
        return link
    before = None if link.surface is None else link.surface.mu1
    return replace(link, surface=Surface(mu1=given.get("mu1", before)))


def _is_self_colliding(robot: Element) -> bool:
    """Return whether all links collide with each other, as set by ``<self_collide>``.

    The element is read directly under ``<robot>`` (only tool0 uses it there) and in
    Gazebo's extensions that apply to the whole model.
    """
    of_model = (
        element
        for element in children(robot, "gazebo")
        if not element.getAttribute("reference")
    )
    flags = [
        flag for item in (robot, *of_model) for flag in children(item, "self_collide")
    ]
    return any([_is_true(flag) for flag in flags])


def _is_true(flag: Element) -> bool:
    text = text_of(flag).lower()
    return choice(text, _BOOLEANS, flag, f"<{flag.tagName}>") in ("true", "1")


def _mark_passive(robot: Element, joints: dict[str, Joint]) -> None:
    """Mark the joints that are driven only by a loop."""
    for element in children(robot, "passive_joint"):
        name = required(element, "name")
        what = "<passive_joint> names the unknown joint"
        require_known(name, joints, what, locate(element))
        if joints[name].mimic is None:
            raise ModelError(
                f"passive joint '{name}' lacks <mimic>, which gives its rest position",
                locate(element),
            )
        joints[name] = replace(joints[name], passive=True)


def _read_transmissions(
    robot: Element, joints: Mapping[str, Joint], drives: Mapping[str, Transmission]
) -> tuple[Transmission, ...]:
    """Return the drives, starting with the drives from ``<ros2_control>``."""
    found: dict[str, Transmission] = {}
    for element in children(robot, "transmission"):
        transmission = read_transmission(element, drives)
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
    return tuple({**drives, **found}.values())


def _check_loops(model: RobotModel) -> None:
    """Raise ModelError unless every loop stays closed over its range of motion.

    The ``<mimic>`` relations of passive joints must keep the loop closed.  The check is
    made at both ends and in the middle of the range of each master joint.
    """
    masters = {
        joint.mimic.joint for joint in model.joints if joint.mimic and joint.passive
    }
    limits = {name: model.joint(name).limits for name in sorted(masters)}
    for share in (0.0, 0.5, 1.0) if model.loops else ():
        position = {
            name: joint.lower + share * (joint.upper - joint.lower)
            for name, joint in limits.items()
            if math.isfinite(joint.upper - joint.lower)
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
