"""A strict reading of URDF: a ``RobotModel``, or an error with file and line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar
from xml.dom.minidom import Document, Element

from tool0.description.attributes import require_known, required
from tool0.description.model import Joint, Link, RobotModel
from tool0.description.urdf_extensions import (
    apply_gazebo,
    read_grippers,
    read_transmissions,
)
from tool0.description.urdf_joints import (
    apply_springs,
    check_loops,
    check_mimics,
    mark_passive,
    read_joint,
    read_loops,
)
from tool0.description.urdf_links import read_link, read_materials
from tool0.description.xml_source import children, locate
from tool0.errors import DescriptionError, ModelError, SourceLocation

Item = TypeVar("Item", Link, Joint)
_Locations = dict[str, SourceLocation]


def read_model(document: Document) -> RobotModel:
    """Return the robot that ``document`` describes.

    Elements that URDF does not know are ignored, as ROS ignores them.

    Raises:
        DescriptionError: If something is missing or cannot be read.
        ModelError: If no robot could be like this.
    """
    robot = document.documentElement
    if robot is None or robot.tagName != "robot":
        tag = "nothing" if robot is None else f"<{robot.tagName}>"
        raise DescriptionError(
            f"the document holds {tag}; a URDF holds <robot>", locate(robot)
        )
    locations: _Locations = {}
    materials = read_materials(robot)
    links: dict[str, Link] = {}
    for element in children(robot, "link"):
        _add(links, "link", read_link(element, materials), element, locations)
    joints: dict[str, Joint] = {}
    for element in children(robot, "joint"):
        _add(joints, "joint", read_joint(element), element, locations)
    if not links:
        raise ModelError("the robot has no <link>; give it at least one", locate(robot))
    check_mimics(joints, locations)
    joints = mark_passive(robot, apply_springs(robot, joints))
    root, ordered = _order(links, joints, locations)
    links = apply_gazebo(robot, links, joints)
    model = RobotModel(
        name=required(robot, "name"),
        root=root,
        links=tuple(links.values()),
        joints=ordered,
        transmissions=read_transmissions(robot, joints),
        grippers=read_grippers(robot, joints),
        loops=read_loops(robot, links),
        locations=locations,
    )
    check_loops(model)
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
    """Return the root link, and the joints depth first; or raise ModelError."""
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
            f"the robot falls apart: no joint leads to {_quoted(roots)}; "
            "join all but one of them to the rest",
            locations.get(f"link:{roots[1]}"),
        )
    ordered = _walk(roots[0], below) if roots else ()
    if len(ordered) != len(joints):
        reached = {joint.name for joint in ordered}
        loop = _loop(above, next(iter(joints[n] for n in joints if n not in reached)))
        raise ModelError(
            f"the joints {_quoted(loop)} form a loop; URDF is a tree: remove one",
            locations.get(f"joint:{loop[0]}"),
        )
    return roots[0], ordered


def _walk(root: str, below: Mapping[str, list[Joint]]) -> tuple[Joint, ...]:
    ordered: list[Joint] = []
    waiting = list(reversed(below[root]))
    while waiting:
        joint = waiting.pop()
        ordered.append(joint)
        waiting.extend(reversed(below[joint.child]))
    return tuple(ordered)


def _loop(above: Mapping[str, Joint], start: Joint) -> list[str]:
    """Return the joints of the loop that is met going up from ``start``."""
    path: list[str] = []
    joint = start
    while joint.name not in path:
        path.append(joint.name)
        joint = above[joint.parent]
    return list(reversed(path[path.index(joint.name) :]))


def _quoted(names: list[str]) -> str:
    return ", ".join(f"'{name}'" for name in names)
