"""Pairs of links of one robot that collide with each other, as in Gazebo."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Sequence

from tool0.description.bodies import MovingBody
from tool0.description.model import Joint, Link, RobotModel


def body_at_rest(link: str) -> str:
    """Return the body name of a link at rest, for exclusions of body pairs."""
    return f"{link}/base"


def excluded_pairs(
    model: RobotModel,
    bodies: tuple[MovingBody, ...],
    at_rest: Sequence[Link],
    colliding: frozenset[str],
) -> Iterator[tuple[str, str]]:
    """Yield the pairs of bodies that never collide, unless both bodies are at rest.

    Bodies of one mechanism can overlap, since the links of a linkage share pivots that
    cannot be expressed in the tree of a URDF.  Within a mechanism, only the pads
    collide with each other.  Other bodies collide if both are ``colliding`` and no
    joint connects them.
    """
    masters = {j.mimic.joint for j in model.movable_joints if j.mimic is not None}
    mechanism = {
        body.joint.child: _mechanism(model, body.joint, masters) for body in bodies
    }
    for first, second in itertools.combinations(bodies, 2):
        one, two = first.joint.child, second.joint.child
        if mechanism[one] is not None and mechanism[one] == mechanism[two]:
            may_collide = _has_pad(model, first) and _has_pad(model, second)
        else:
            may_collide = one in colliding and two in colliding
        if not may_collide:
            yield one, two
    for link in at_rest:
        for body in bodies:
            child = body.joint.child
            # MuJoCo excludes bodies that share a joint, unless one of the bodies is at
            # rest.
            is_adjacent = body.joint.parent == link.name
            if is_adjacent or not (link.name in colliding and child in colliding):
                yield body_at_rest(link.name), child


def self_colliding(model: RobotModel, bodies: tuple[MovingBody, ...]) -> frozenset[str]:
    """Return the links that collide with other links, following Gazebo's rules.

    The result includes links that are fixed to a colliding link.
    """
    if model.self_collide:
        return frozenset(model.link_by_name)
    found = {link.name for link in model.links if link.self_collide}
    for body in bodies:
        names = {name for name, _ in body.links}
        found |= names if names & found else set()
    return frozenset(found)


def _mechanism(model: RobotModel, joint: Joint, masters: Collection[str]) -> str | None:
    """Return the joint that drives the mechanism of ``joint``, or None."""
    if joint.mimic is None and joint.name not in masters:
        return None
    while joint.mimic is not None:
        joint = model.joint_by_name[joint.mimic.joint]
    return joint.name


def _has_pad(model: RobotModel, body: MovingBody) -> bool:
    return any(model.link(name).surface is not None for name, _ in body.links)
