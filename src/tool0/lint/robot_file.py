"""Applies all rules to one robot, and to one xacro file before its expansion."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import final

from tool0.description.expansion import expand_leniently
from tool0.description.finding import Finding, error_at, warning_at
from tool0.description.packages import preferring
from tool0.description.urdf import read_model
from tool0.description.xml_source import LocatedElement, parse_file
from tool0.errors import SourceLocation, Tool0Error, is_typo, nearest_name
from tool0.lint.packages import PackageIndex, Packages
from tool0.lint.robot import gazebo, joints, masses, xacro_source
from tool0.lint.robot.elements import Tag
from tool0.lint.robot.facts import Robot, RobotFacts, facts_of
from tool0.lint.robot.meshes import mesh_findings
from tool0.lint.robot.transmissions import transmission_findings
from tool0.lint.robot.tree import tree_findings
from tool0.lint.sources import finding_of

_DEFINES = frozenset({"xacro:include", "xacro:macro", "xacro:property", "xacro:arg"})
_NONE: Packages = MappingProxyType({})
_ROBOT_RULES = (
    tree_findings,
    joints.joint_findings,
    joints.value_findings,
    masses.inertia_findings,
    transmission_findings,
    gazebo.plugin_findings,
    gazebo.extension_findings,
    joints.mimic_findings,
    gazebo.follower_findings,
    masses.effort_findings,
    mesh_findings,
)
_XACRO_RULES = (
    xacro_source.include_findings,
    xacro_source.parameter_findings,
    xacro_source.call_findings,
    xacro_source.interface_findings,
)
_USED = re.compile(r"\$\(arg +(\w+) *\)")
_MOST = 50
"""Largest number of findings that are reported for one subject.  Once these have been
fixed, another check reports more findings."""


@final
@dataclass(frozen=True, slots=True)
class ParsedRobot:
    """The readable parts of a robot, and the findings about it."""

    facts: RobotFacts | None
    findings: tuple[Finding, ...]


@final
@dataclass(frozen=True, slots=True)
class XacroSource:
    """The content of a xacro file before its expansion."""

    findings: tuple[Finding, ...]
    makes_a_robot: bool
    """Whether the file creates elements, rather than only defining macros."""
    includes: tuple[Path, ...]
    """Absolute paths of the files that the file includes, whatever its arguments
    are."""
    needs: tuple[str, ...]
    """Arguments that have no default value, or an empty one, where they are used."""


def read_robot(
    file: Path,
    args: Mapping[str, str] | None,
    packages: Packages,
    *,
    spawned: bool | None = None,
) -> ParsedRobot:
    """Return the robot in a file, and the findings about the robot.

    Args:
        file: A URDF or xacro file.
        args: The arguments of xacro; None if the file is URDF.
        packages: Packages that take precedence over others.
        spawned: Whether the robot is spawned in Gazebo for control; None if unknown.
    """
    with preferring(packages):
        try:
            document, known, _ = (
                (parse_file(file), set(), {})
                if args is None
                else expand_leniently(file, args)
            )
        except Tool0Error as error:
            rule = "bad-xml" if args is None else "xacro-fails"
            return ParsedRobot(None, (finding_of(error, rule, file),))
        root = document.documentElement
        if not isinstance(root, LocatedElement) or root.tagName != "robot":
            name = "nothing" if root is None else f"<{root.tagName}>"
            wrong = Tool0Error(f"begins with {name}, and no <robot>")
            return ParsedRobot(None, (finding_of(wrong, "no-robot", file),))
        # a .srdf.xacro file contains groups of joints, but no robot
        if file.name.endswith(".srdf.xacro"):
            return ParsedRobot(None, ())
        findings = (
            *_unused(file, args or (), known),
            *robot_findings(root, packages, spawned=spawned),
        )
        facts = facts_of(Tag(root))
        if any(finding.severity == "error" for finding in findings):
            return ParsedRobot(facts, findings)
        # because of other faults, tool0 may be unable to simulate a robot that ROS
        # accepts
        try:
            read_model(document)
        except Tool0Error as error:
            found = finding_of(error, "no-model", file)
            if found.location not in {finding.location for finding in findings}:
                findings += (replace(found, severity="warning"),)
        return ParsedRobot(facts, findings)


def _unused(file: Path, given: Iterable[str], known: set[str]) -> Iterator[Finding]:
    """Yield the given arguments that xacro ignores.

    A misspelled argument is an error.
    """
    where = SourceLocation(file)
    for name in sorted(set(given) - known):
        near = nearest_name(name, known)
        message = f"no file declares the argument '{name}'"
        if is_typo(name, near):
            hint = f"did you mean '{near}'?"
            yield error_at(where, "xacro-fails", name, message, hint)
        else:
            yield warning_at(
                where,
                "unused-argument",
                name,
                f"{message}, and xacro ignores it",
                f'declare it by <xacro:arg name="{name}" default="…"/>, or do not '
                "give it",
            )


def read_xacro_source(file: Path, packages: Packages) -> XacroSource:
    """Return the content of a xacro file before expansion."""
    nothing = XacroSource((), makes_a_robot=False, includes=(), needs=())
    with preferring(packages):
        try:
            root = parse_file(file).documentElement
        except Tool0Error as error:
            return replace(nothing, findings=(finding_of(error, "bad-xml", file),))
        if not isinstance(root, LocatedElement):
            return nothing
        tag = Tag(root)
        files = xacro_source.included_files(tag, PackageIndex(packages))
        return XacroSource(
            findings=tuple(xacro_findings(root, packages)),
            makes_a_robot=any(item.tag not in _DEFINES for item in tag.children()),
            includes=tuple(Path(os.path.realpath(path)) for path in files),
            needs=(
                *_USED.findall("\n".join(value for _, value in tag.attributes)),
                *(
                    item.written("name")
                    for item in tag.children("xacro:arg")
                    if not item.written("default")
                ),
            ),
        )


def robot_findings(
    root: LocatedElement, packages: Packages = _NONE, *, spawned: bool | None = None
) -> Iterator[Finding]:
    """Yield the findings in the <robot> of a URDF or an expanded xacro file."""
    facts = facts_of(Tag(root))
    robot = Robot(Tag(root), facts, facts.bodies(), PackageIndex(packages), spawned)
    for rules in _ROBOT_RULES:
        yield from _at_most(rules(robot))


def xacro_findings(
    root: LocatedElement, packages: Packages = _NONE
) -> Iterator[Finding]:
    """Yield the findings in a xacro file before its expansion."""
    for rules in _XACRO_RULES:
        yield from _at_most(rules(Tag(root), PackageIndex(packages)))


def _at_most(findings: Iterator[Finding]) -> Iterator[Finding]:
    """Yield at most ``_MOST`` findings.

    If there are more findings, add a finding that reports them.
    """
    for count, finding in enumerate(findings, 1):
        if count > _MOST:
            message = f"and more such as this: {finding.message}"
            yield replace(finding, message=message)
            return
        yield finding
