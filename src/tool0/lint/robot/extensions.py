"""What <gazebo> says about links, joints and bodies that the robot lacks."""

from __future__ import annotations

from collections.abc import Iterator
from xml.dom.minidom import Element

from tool0.description.finding import Finding, error_at, warning_at
from tool0.description.xml_source import children
from tool0.errors import nearest_name
from tool0.lint.robot.bodies import bodies
from tool0.lint.robot.elements import attribute, place
from tool0.lint.robot.facts import RobotFacts
from tool0.lint.robot.names import short


def extension_findings(root: Element, facts: RobotFacts) -> Iterator[Finding]:
    """Yield the extensions that refer to nothing."""
    known = {**facts.links, **facts.joints}
    for element in children(root, "gazebo"):
        name = attribute(element, "reference")
        if name and name not in known:
            close = nearest_name(name, known)
            yield warning_at(
                place(element),
                "unknown-reference",
                name,
                f'<gazebo reference="{short(name)}"> is about neither a link nor '
                "a joint of the robot, so it does nothing",
                f'write reference="{close}"' if close else "remove it",
            )
    yield from _gearboxes(facts)


def _gearboxes(facts: RobotFacts) -> Iterator[Finding]:
    body = bodies(facts)
    for gearbox in facts.gearboxes:
        for role, name in (("parent", gearbox.parent), ("child", gearbox.child)):
            if name in facts.links:
                merged = body[name]
                if merged == name:
                    continue
                reason = f"Gazebo has merged into '{short(merged)}'"
                remedy = f"write <{role}>{merged}</{role}>"
            else:
                close = nearest_name(name, facts.links)
                reason = "the robot lacks"
                remedy = (
                    f"write <{role}>{close}</{role}>"
                    if close
                    else "name one of its links"
                )
            yield error_at(
                gearbox.location,
                "unknown-link",
                gearbox.name,
                f"gearbox '{short(gearbox.name)}' has the {role} '{short(name)}', "
                f"which {reason}: Gazebo does not make the gearbox, and the "
                "finger hangs loose",
                remedy,
            )
