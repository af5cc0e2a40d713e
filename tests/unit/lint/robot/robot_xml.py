"""Small robots for the tests of the rules, and the findings about them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tool0.description.finding import Finding
from tool0.description.xml_source import LocatedElement, parse_text
from tool0.lint.robot_file import robot_findings, xacro_findings

INERTIAL = (
    '<inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" '
    'iyz="0" izz="0.01"/></inertial>'
)
LIMIT = '<limit lower="-1" upper="1" effort="10" velocity="2"/>'


def link(name: str, inside: str = INERTIAL) -> str:
    return f'<link name="{name}">{inside}</link>'


def joint(
    name: str,
    parent: str,
    child: str,
    inside: str = '<axis xyz="0 0 1"/>' + LIMIT,
    type: str = "revolute",
) -> str:
    return (
        f'<joint name="{name}" type="{type}"><parent link="{parent}"/>'
        f'<child link="{child}"/>{inside}</joint>'
    )


def transmission(
    joint: str,
    interface: str = "hardware_interface/EffortJointInterface",
    type: str = "transmission_interface/SimpleTransmission",
    actuator: str = '<actuator name="motor"/>',
) -> str:
    return (
        f'<transmission name="{joint}_trans"><type>{type}</type><joint name="{joint}">'
        f"<hardwareInterface>{interface}</hardwareInterface></joint>{actuator}"
        "</transmission>"
    )


def plugin(filename: str = "libgazebo_ros_control.so", inside: str = "") -> str:
    return f'<gazebo><plugin name="p" filename="{filename}">{inside}</plugin></gazebo>'


ARM = link("world", "") + joint("hinge", "world", "arm") + link("arm")
DRIVEN = ARM + transmission("hinge") + plugin()


def root_of(*parts: str, file: Path | None = None) -> LocatedElement:
    """Return the <robot> of ``parts``, each on a line of its own from 2 on."""
    text = "\n".join(
        ('<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">', *parts)
    )
    root = parse_text(text + "\n</robot>", file).documentElement
    assert isinstance(root, LocatedElement)
    return root


def check(
    *parts: str,
    spawned: bool | None = False,
    packages: dict[str, Path] | None = None,
) -> list[Finding]:
    return list(robot_findings(root_of(*parts), packages or {}, spawned=spawned))


def check_xacro(*parts: str, file: Path | None = None) -> list[Finding]:
    return list(xacro_findings(root_of(*parts, file=file)))


def rules(findings: list[Finding]) -> list[str]:
    return [finding.rule for finding in findings]


def only(findings: list[Finding], rule: str) -> Finding:
    assert rules(findings) == [rule], [str(finding) for finding in findings]
    return findings[0]


def fault(
    rule: str, *parts: str, line: int | None = None, named: str = "", severity: str = ""
) -> object:
    """Return a case: a robot with one fault, its line, and a name in its text."""
    return pytest.param(parts, rule, line, named, severity, id=f"{rule}-{named}")


def assert_only(
    parts: tuple[str, ...], rule: str, line: int | None, named: str, severity: str
) -> None:
    """Fail unless the robot has this fault and no other."""
    finding = only(check(*parts), rule)
    assert line in (None, finding.location.line)
    assert severity in ("", finding.severity)
    assert named in finding.text, finding.text
