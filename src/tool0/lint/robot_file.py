"""All rules for one robot, expanded from xacro or not, and for one xacro file."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import final

from tool0.description.expansion import expand
from tool0.description.finding import Finding, error_at
from tool0.description.packages import preferring
from tool0.description.urdf import read_model
from tool0.description.xml_source import LocatedElement, children, parse_file
from tool0.errors import SourceLocation, Tool0Error
from tool0.lint.packages import PackageIndex
from tool0.lint.robot import bodies, gazebo, joints, xacro_source
from tool0.lint.robot.elements import Tag
from tool0.lint.robot.facts import Robot, RobotFacts, facts_of
from tool0.lint.robot.inertias import inertia_findings
from tool0.lint.robot.meshes import mesh_findings
from tool0.lint.robot.transmissions import transmission_findings
from tool0.lint.robot.tree import tree_findings

_DEFINES = frozenset({"xacro:include", "xacro:macro", "xacro:property", "xacro:arg"})
_NONE: Mapping[str, Path] = MappingProxyType({})
_ROBOT_RULES = (
    tree_findings,
    joints.joint_findings,
    joints.value_findings,
    inertia_findings,
    transmission_findings,
    gazebo.plugin_findings,
    gazebo.extension_findings,
    joints.mimic_findings,
    gazebo.follower_findings,
    bodies.effort_findings,
    mesh_findings,
)
_XACRO_RULES = (
    xacro_source.include_findings,
    xacro_source.parameter_findings,
    xacro_source.call_findings,
    xacro_source.interface_findings,
)
_MOST = 50
"""Findings of one subject; a file with more needs another look after these."""


@final
@dataclass(frozen=True, slots=True)
class ParsedRobot:
    """A robot as far as it could be read."""

    facts: RobotFacts | None
    findings: tuple[Finding, ...]


@final
@dataclass(frozen=True, slots=True)
class XacroSource:
    """A xacro file as it is written."""

    findings: tuple[Finding, ...]
    makes_a_robot: bool
    """Whether it makes something by itself, rather than defining macros."""
    includes: tuple[Path, ...]
    """The files that it includes, whatever its arguments are; absolute."""
    needs: tuple[str, ...]
    """The arguments that have no default, or an empty one."""


def read_robot(
    file: Path,
    args: Mapping[str, str] | None,
    packages: Mapping[str, Path],
    *,
    spawned: bool = False,
) -> ParsedRobot:
    """Return the robot of a file, and what is wrong with it.

    Args:
        file: URDF or xacro.
        args: The arguments of xacro; None if the file is URDF.
        packages: Name → folder of packages that come before all others.
        spawned: Whether it is known to be put into Gazebo.
    """
    with preferring(packages):
        try:
            document = parse_file(file) if args is None else expand(file, args)
        except Tool0Error as error:
            rule = "bad-xml" if args is None else "xacro-fails"
            return ParsedRobot(None, (_as_finding(error, rule, file),))
        root = document.documentElement
        if not isinstance(root, LocatedElement) or root.tagName != "robot":
            name = "nothing" if root is None else f"<{root.tagName}>"
            wrong = Tool0Error(f"begins with {name}, and no <robot>")
            return ParsedRobot(None, (_as_finding(wrong, "no-robot", file),))
        findings = tuple(robot_findings(root, packages, spawned=spawned))
        facts = facts_of(Tag(root))
        if any(finding.severity == "error" for finding in findings):
            return ParsedRobot(facts, findings)
        try:  # what else keeps tool0 from simulating it, though ROS may take it
            read_model(document)
        except Tool0Error as error:
            found = _as_finding(error, "no-model", file)
            if found.location not in {finding.location for finding in findings}:
                findings += (replace(found, severity="warning"),)
        return ParsedRobot(facts, findings)


def read_xacro_source(file: Path, packages: Mapping[str, Path]) -> XacroSource:
    """Return what a xacro file holds before any expansion."""
    with preferring(packages):
        try:
            root = parse_file(file).documentElement
        except Tool0Error as error:
            finding = _as_finding(error, "bad-xml", file)
            return XacroSource((finding,), makes_a_robot=False, includes=(), needs=())
        if not isinstance(root, LocatedElement):
            return XacroSource((), makes_a_robot=False, includes=(), needs=())
        makes = any(item.tagName not in _DEFINES for item in children(root))
        needs = tuple(
            item.getAttribute("name")
            for item in children(root, "xacro:arg")
            if not item.getAttribute("default")
        )
        files = xacro_source.included_files(Tag(root), PackageIndex(packages))
        return XacroSource(
            findings=tuple(xacro_findings(root, packages)),
            makes_a_robot=makes,
            includes=tuple(map(_resolved, files)),
            needs=needs,
        )


def _resolved(path: Path) -> Path:
    return Path(os.path.realpath(path))


def _as_finding(error: Tool0Error, rule: str, file: Path) -> Finding:
    location: SourceLocation | None = getattr(error, "location", None)
    message: str = getattr(error, "message", str(error))
    return error_at(
        location or SourceLocation(file),
        rule,
        "",
        message,
    )


def robot_findings(
    root: LocatedElement, packages: Mapping[str, Path] = _NONE, *, spawned: bool = False
) -> Iterator[Finding]:
    """Yield what is wrong in a <robot> of URDF, or of expanded xacro.

    Args:
        root: The <robot>.
        packages: Folders of packages by name, which are found before any other.
        spawned: Whether it is known to be put into Gazebo to be controlled there.
    """
    facts = facts_of(Tag(root))
    robot = Robot(Tag(root), facts, facts.bodies(), PackageIndex(packages), spawned)
    for rules in _ROBOT_RULES:
        yield from _at_most(rules(robot))


def xacro_findings(
    root: LocatedElement, packages: Mapping[str, Path] = _NONE
) -> Iterator[Finding]:
    """Yield what is wrong in a xacro file as it is written, before any expansion."""
    for rules in _XACRO_RULES:
        yield from _at_most(rules(Tag(root), PackageIndex(packages)))


def _at_most(findings: Iterator[Finding]) -> Iterator[Finding]:
    """Yield at most ``_MOST`` and one more, which says that there are others."""
    for count, finding in enumerate(findings, 1):
        if count > _MOST:
            message = f"and more such as this: {finding.message}"
            yield replace(finding, message=message)
            return
        yield finding
