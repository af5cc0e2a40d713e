"""Links and joints that make no tree: two of one name, unknown, two parents, loops."""

from __future__ import annotations

from collections.abc import Iterator
from xml.dom.minidom import Element

from tool0.description.finding import Finding, error_at, quoted, short
from tool0.description.xml_source import children
from tool0.errors import SourceLocation, nearest_name
from tool0.lint.robot.elements import attribute, place
from tool0.lint.robot.facts import JointFacts, RobotFacts

_REFUSED = "so ROS refuses the whole robot_description"


def tree_findings(root: Element, facts: RobotFacts) -> Iterator[Finding]:
    """Yield what keeps links and joints from being one tree."""
    yield from _unnamed(root)
    for kind in ("link", "joint"):
        yield from _duplicates(root, kind)
    yield from _unknown_links(facts)
    yield from _two_parents(facts)
    yield from _roots(root, facts)
    yield from _loops(facts)


def _unnamed(root: Element) -> Iterator[Finding]:
    owners = [root, *children(root, "link"), *children(root, "joint")]
    for element in owners:
        if not attribute(element, "name"):
            yield error_at(
                place(element),
                "unnamed",
                f"<{element.tagName}>",
                f"this <{element.tagName}> has no name, {_REFUSED}",
                'give it name="…"',
            )


def _duplicates(root: Element, kind: str) -> Iterator[Finding]:
    first: dict[str, SourceLocation] = {}
    for element in children(root, kind):
        name = attribute(element, "name")
        if name not in first:
            first[name] = place(element)
        elif name:
            yield error_at(
                place(element),
                f"duplicate-{kind}",
                name,
                f"{kind} '{short(name)}' is defined twice, first at {first[name]}, "
                f"{_REFUSED}: often an arm and a gripper both bring one",
                _one_name(kind, name),
            )


def _one_name(kind: str, name: str) -> str:
    if name.endswith("base_link"):
        return (
            "leave out the gripper's, with the fixed joint below it, and attach the "
            "next link to the arm's tool0; or give one of the two a prefix"
        )
    return f"give the macro of one of them a prefix, or remove one {kind}"


def _unknown_links(facts: RobotFacts) -> Iterator[Finding]:
    for joint in facts.joints.values():
        for role, name in (("parent", joint.parent), ("child", joint.child)):
            if not name:
                yield error_at(
                    joint.location,
                    "unknown-link",
                    joint.name,
                    f"joint '{short(joint.name)}' names no {role} link, {_REFUSED}",
                    f'write <{role} link="…"/> in it',
                )
            elif name not in facts.links:
                close = nearest_name(name, facts.links)
                yield error_at(
                    joint.location,
                    "unknown-link",
                    joint.name,
                    f"joint '{short(joint.name)}' has the {role} link "
                    f"'{short(name)}', which the robot lacks, {_REFUSED}",
                    f'write <{role} link="{close}"/>; a prefix that a macro gets '
                    "stands before all its names"
                    if close
                    else f"the robot has {quoted(facts.links)}",
                )


def _two_parents(facts: RobotFacts) -> Iterator[Finding]:
    above: dict[str, JointFacts] = {}
    for joint in facts.joints.values():
        if joint.child not in facts.links:
            continue
        first = above.setdefault(joint.child, joint)
        if first is not joint:
            yield error_at(
                joint.location,
                "two-parents",
                joint.child,
                f"link '{short(joint.child)}' hangs on two joints, "
                f"'{short(first.name)}' at {first.location} and "
                f"'{short(joint.name)}', {_REFUSED}: URDF is a tree",
                "remove one of the joints, or swap <parent> and <child> of the "
                "one that is meant the other way round",
            )


def _roots(root: Element, facts: RobotFacts) -> Iterator[Finding]:
    if not facts.links:
        yield error_at(
            place(root),
            "no-root",
            facts.name,
            f"the robot has no <link>, {_REFUSED}",
            'give it one, such as <link name="base_link"/>',
        )
        return
    children_of_joints = {joint.child for joint in facts.joints.values()}
    if not children_of_joints <= facts.links.keys():
        return  # a misspelt child leaves the link it means without a joint
    roots = [name for name in facts.links if name not in children_of_joints]
    if not roots:
        yield error_at(
            place(root),
            "no-root",
            facts.name,
            f"every link is the child of a joint, {_REFUSED}: nothing is first",
            "remove the joint that leads back to the first link",
        )
    elif len(roots) > 1:
        places = ", ".join(
            f"'{short(name)}' at {facts.links[name]}" for name in roots[:4]
        )
        yield error_at(
            facts.links[roots[1]],
            "two-roots",
            roots[1],
            f"no joint leads to {len(roots)} of the links ({places}), {_REFUSED}: "
            "it has two roots",
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
            yield error_at(
                upward.location,
                "loop",
                upward.name,
                f"the joints {quoted(loop)} form a loop, {_REFUSED}",
                "remove one of them; a closed linkage is simulated with mimic "
                "joints and a gearbox or a constraint of the simulator",
            )
        done.update(path)
