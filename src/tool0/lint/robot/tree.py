"""Finds links and joints that do not form a tree.

The causes are duplicate names, unknown names, loops and links with two parents.
"""

from __future__ import annotations

from collections.abc import Iterator

from tool0.description.finding import Finding, quoted, short
from tool0.errors import SourceLocation
from tool0.lint.robot.elements import Subject, Tag, suggestion
from tool0.lint.robot.facts import JointFacts, Robot, RobotFacts

_REFUSED = "so ROS refuses the whole robot_description"


def tree_findings(robot: Robot) -> Iterator[Finding]:
    """Yield the faults that prevent the links and joints from forming one tree."""
    root, facts = robot.root, robot.facts
    for tag in (root, *root.children("link"), *root.children("joint")):
        if not tag["name"]:
            yield tag.at.error(
                "unnamed",
                f"this <{tag.tag}> has no name, {_REFUSED}",
                'give it name="…"',
                key=f"<{tag.tag}>",
            )
    yield from _duplicates(root, "link")
    yield from _duplicates(root, "joint")
    yield from _unknown_links(facts)
    yield from _two_parents(facts)
    yield from _roots(Subject(facts.name, root.location), facts)
    yield from _loops(facts)


def _duplicates(root: Tag, kind: str) -> Iterator[Finding]:
    first: dict[str, SourceLocation] = {}
    for tag in root.children(kind):
        name = tag["name"]
        if name not in first:
            first[name] = tag.location
        elif name:
            yield tag.at.error(
                f"duplicate-{kind}",
                f"{kind} '{short(name)}' is defined twice, first at {first[name]}, "
                f"{_REFUSED}: often an arm and a gripper both bring one",
                "leave out the gripper's, with the fixed joint below it, and attach "
                "the next link to the arm's tool0; or give one of the two a prefix"
                if name.endswith("base_link")
                else f"give the macro of one of them a prefix, or remove one {kind}",
            )


def _unknown_links(facts: RobotFacts) -> Iterator[Finding]:
    for joint in facts.joints.values():
        for role, name in (("parent", joint.parent), ("child", joint.child)):
            if not name:
                yield joint.at.error(
                    "unknown-link",
                    f"joint '{short(joint.name)}' names no {role} link, {_REFUSED}",
                    f'write <{role} link="…"/> in it',
                )
            elif name not in facts.links:
                yield joint.at.error(
                    "unknown-link",
                    f"joint '{short(joint.name)}' has the {role} link "
                    f"'{short(name)}', which the robot lacks, {_REFUSED}",
                    suggestion(
                        name,
                        facts.links,
                        f'write <{role} link="{{}}"/>; the prefix of a macro '
                        "is part of all its names",
                        f"the robot has {quoted(facts.links)}",
                    ),
                )


def _two_parents(facts: RobotFacts) -> Iterator[Finding]:
    above: dict[str, JointFacts] = {}
    for joint in facts.joints.values():
        first = above.setdefault(joint.child, joint)
        if first is not joint and joint.child in facts.links:
            yield joint.at.error(
                "two-parents",
                f"link '{short(joint.child)}' has two parent joints, "
                f"'{short(first.name)}' at {first.at.location} and "
                f"'{short(joint.name)}', {_REFUSED}: URDF is a tree",
                "remove one of the joints, or swap <parent> and <child> of the "
                "one that is meant the other way round",
                key=joint.child,
            )


def _roots(root: Subject, facts: RobotFacts) -> Iterator[Finding]:
    if not facts.links:
        yield root.error(
            "no-root",
            f"the robot has no <link>, {_REFUSED}",
            'give it one, such as <link name="base_link"/>',
        )
        return
    children_of_joints = {joint.child for joint in facts.joints.values()}
    if not children_of_joints <= facts.links.keys():
        return  # a misspelled child leaves the intended link without a joint
    roots = [name for name in facts.links if name not in children_of_joints]
    if not roots:
        yield root.error(
            "no-root",
            f"every link is the child of a joint, {_REFUSED}: nothing is first",
            "remove the joint that leads back to the first link",
        )
    elif len(roots) > 1:
        places = [f"'{short(name)}' at {facts.links[name]}" for name in roots[:4]]
        yield Subject(roots[1], facts.links[roots[1]]).error(
            "two-roots",
            f"no joint leads to {len(roots)} of the links ({', '.join(places)}), "
            f"{_REFUSED}: it has two roots",
            "join all but one of them to the rest, as with a fixed joint from "
            "the arm's tool0 to the first link of the gripper",
        )


def _loops(facts: RobotFacts) -> Iterator[Finding]:
    above: dict[str, JointFacts] = {}
    for joint in facts.joints.values():
        above.setdefault(joint.child, joint)
    done: set[str] = set()
    for start in facts.joints.values():
        path: dict[str, JointFacts] = {}
        upward: JointFacts | None = start
        while upward and upward.name not in done and upward.name not in path:
            path[upward.name] = upward
            upward = above.get(upward.parent)
        if upward and upward.name in path:
            names = list(path)
            loop = names[names.index(upward.name) :]
            yield upward.at.error(
                "loop",
                f"the joints {quoted(loop)} form a loop, {_REFUSED}",
                "remove one of them; a closed linkage is simulated with mimic "
                "joints and a gearbox or a constraint of the simulator",
            )
        done.update(path)
