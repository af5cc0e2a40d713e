"""The rigid bodies that Gazebo makes of a robot, and how large a link is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from xml.dom.minidom import Element

from tool0.description.xml_source import children
from tool0.lint.robot.elements import attribute, child, length, number, vector
from tool0.lint.robot.facts import JointFacts, RobotFacts


def joints_above(facts: RobotFacts) -> Mapping[str, JointFacts]:
    """Return the joint on which each link hangs; the first, if it has several."""
    above: dict[str, JointFacts] = {}
    for joint in facts.joints.values():
        if joint.child in facts.links:
            above.setdefault(joint.child, joint)
    return above


def bodies(facts: RobotFacts) -> Mapping[str, str]:
    """Return, for each link, the first link of the body that it is merged into."""
    above = joints_above(facts)
    body: dict[str, str] = {}
    for link in facts.links:
        path: dict[str, None] = {}
        at = link
        while at not in body and at not in path:
            path[at] = None
            joint = above.get(at)
            if joint is None or facts.moves(joint) or joint.parent not in facts.links:
                break
            at = joint.parent
        body.update(dict.fromkeys(path, body.get(at, at)))
    return body


def extent_of(link: Element) -> float | None:
    """Return about how long ``link`` is [m]; None if it is not known.

    The shapes that it collides with count; if some are meshes, those that are drawn.
    """
    for tag in ("collision", "visual"):
        owners = list(children(link, tag))
        reaches = [_reach(owner) for owner in owners]
        known = [reach for reach in reaches if reach is not None]
        if known and len(known) == len(reaches):
            return _spread(known)
    return None


def reach_of(link: Element) -> float:
    """Return how far from the link's origin anything of it is, at most [m].

    Meshes are not opened: of them only the origin counts, and the centre of mass.
    """
    inertial = child(link, "inertial")
    farthest = [length(_xyz(inertial))]
    for tag in ("collision", "visual"):
        for owner in children(link, tag):
            size = _size(owner)
            farthest.append(length(_xyz(owner)) + (size or 0.0) / 2)
    return max(farthest)


def _spread(reaches: Sequence[tuple[tuple[float, ...], float]]) -> float:
    """Return the longest diagonal of the boxes around balls: centres and diameters."""
    edges = (
        max(centre[axis] + size / 2 for centre, size in reaches)
        - min(centre[axis] - size / 2 for centre, size in reaches)
        for axis in range(3)
    )
    return max(edges)


def _reach(owner: Element) -> tuple[tuple[float, ...], float] | None:
    size = _size(owner)
    return None if size is None else (_xyz(owner), size)


def _xyz(owner: Element | None) -> tuple[float, ...]:
    return vector(child(owner, "origin"), "xyz") or (0.0, 0.0, 0.0)


def _size(owner: Element) -> float | None:
    """Return the diameter [m] of the ball around a shape; None of a mesh."""
    geometry = child(owner, "geometry")
    box = vector(child(geometry, "box"), "size")
    if box is not None and min(box) > 0:
        return length(box)
    for tag in ("cylinder", "sphere"):
        shape = child(geometry, tag)
        radius = number(shape, "radius")
        if radius is None or radius <= 0:
            continue
        along = number(shape, "length") if attribute(shape, "length") else 0.0
        if tag == "sphere":
            return 2 * radius
        if along is not None and along > 0:
            return length((2 * radius, along))
    return None
