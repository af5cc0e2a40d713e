"""The rigid bodies that Gazebo makes of a robot: it merges links with fixed joints."""

from __future__ import annotations

from collections.abc import Mapping

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
