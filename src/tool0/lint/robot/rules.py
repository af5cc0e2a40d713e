"""All the rules for one robot, and for one xacro file as it is written."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType

from tool0.description.finding import Finding
from tool0.description.xml_source import LocatedElement
from tool0.lint.robot.efforts import effort_findings
from tool0.lint.robot.extensions import extension_findings
from tool0.lint.robot.facts import facts_of
from tool0.lint.robot.inertias import inertia_findings
from tool0.lint.robot.joints import joint_findings
from tool0.lint.robot.meshes import mesh_findings
from tool0.lint.robot.mimics import mimic_findings
from tool0.lint.robot.plugins import plugin_findings
from tool0.lint.robot.transmissions import transmission_findings
from tool0.lint.robot.tree import tree_findings
from tool0.lint.robot.values import value_findings
from tool0.lint.robot.xacro_calls import call_findings
from tool0.lint.robot.xacro_includes import include_findings
from tool0.lint.robot.xacro_interfaces import interface_findings
from tool0.lint.robot.xacro_parameters import parameter_findings

_NONE: Mapping[str, Path] = MappingProxyType({})
_MOST = 50
"""Findings of one subject; a file with more needs another look after these."""


def robot_findings(
    root: LocatedElement, packages: Mapping[str, Path] = _NONE, *, spawned: bool = False
) -> Iterator[Finding]:
    """Yield what is wrong in a <robot> of URDF, or of expanded xacro.

    Args:
        root: The <robot>.
        packages: Folders of packages by name, which are found before any other.
        spawned: Whether it is known to be put into Gazebo to be controlled there.
    """
    facts = facts_of(root)
    for subject in (
        tree_findings(root, facts),
        joint_findings(root, facts),
        value_findings(root),
        inertia_findings(root, facts, spawned),
        transmission_findings(facts, spawned),
        plugin_findings(facts, spawned),
        extension_findings(root, facts),
        mimic_findings(facts, spawned),
        effort_findings(root, facts),
        mesh_findings(root, packages),
    ):
        yield from _some(subject)


def xacro_findings(
    root: LocatedElement, packages: Mapping[str, Path] = _NONE
) -> Iterator[Finding]:
    """Yield what is wrong in a xacro file as it is written, before any expansion."""
    for subject in (
        include_findings(root, packages),
        parameter_findings(root),
        call_findings(root),
        interface_findings(root),
    ):
        yield from _some(subject)


def _some(findings: Iterator[Finding]) -> Iterator[Finding]:
    """Yield at most ``_MOST``; the last says that there are more."""
    for count, finding in enumerate(findings, 1):
        if count > _MOST:
            yield Finding(
                location=finding.location,
                rule=finding.rule,
                severity=finding.severity,
                key=finding.key,
                message=f"and more such as this: {finding.message}",
                remedy=finding.remedy,
            )
            return
        yield finding
