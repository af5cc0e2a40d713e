from __future__ import annotations

from pathlib import Path
from xml.dom.minidom import Document

import pytest

from tool0.description.catalogue import arms, grippers
from tool0.description.expansion import expand
from tool0.description.loading import assemble
from tool0.description.model import JointType
from tool0.description.packages import BUNDLED
from tool0.description.xml_source import LocatedElement, parse_file, parse_text
from tool0.lint.robot_file import robot_findings, xacro_findings

DATA = Path(__file__).parents[3] / "data" / "checks" / "robot"
FAULTY = DATA / "arm_with_gripper.urdf.xacro"


def root_of(document: Document) -> LocatedElement:
    assert isinstance(document.documentElement, LocatedElement)
    return document.documentElement


ROBOTS = [(arm, None) for arm in arms()] + [(arms()[0], name) for name in grippers()]


@pytest.mark.slow
@pytest.mark.parametrize(("arm", "gripper"), ROBOTS)
@pytest.mark.parametrize("prefix", ["", "left_"])
@pytest.mark.parametrize("safety", [False, True])
def test_the_projects_own_robots_are_no_false_alarm(
    arm: str, gripper: str | None, prefix: str, safety: bool
) -> None:
    robot = assemble(arm, gripper, prefix=prefix, safety_limits=safety)
    found = list(robot_findings(root_of(parse_text(robot.urdf))))
    # True of fingers that slide: plain Gazebo cannot couple them
    # (docs/how-to/workspace.md).
    loose = [
        joint.name
        for joint in robot.model.joints
        if joint.mimic is not None and joint.type is JointType.PRISMATIC
    ]
    assert [(item.rule, item.key) for item in found] == [
        ("loose-mimic", name) for name in loose
    ]


SOURCES = sorted(BUNDLED.rglob("*.xacro"))


@pytest.mark.parametrize("file", SOURCES, ids=lambda path: path.name)
def test_the_projects_own_xacro_files_are_no_false_alarm(file: Path) -> None:
    assert list(xacro_findings(root_of(parse_file(file)))) == []


def test_the_faults_of_an_arm_with_a_gripper_are_all_named() -> None:
    found = list(robot_findings(root_of(expand(FAULTY).document)))
    assert sorted((finding.rule, finding.key) for finding in found) == [
        ("absurd-effort", "finger_joint"),
        ("duplicate-link", "base_link"),
        ("interface-typo", "hardware/interface/EffortJointInterface"),
        ("teleported-mimic", "right_finger_joint"),
        ("two-parents", "palm"),
        ("two-plugins", "ros_control"),
    ]
    assert {finding.location.file for finding in found} == {FAULTY}
    assert all(finding.location.line for finding in found)
    assert all(finding.remedy for finding in found)
    (twice,) = (finding for finding in found if finding.rule == "two-plugins")
    assert "called twice" in twice.message


def test_the_faults_of_its_xacro_as_it_is_written() -> None:
    found = list(xacro_findings(root_of(parse_file(FAULTY))))
    assert sorted((finding.rule, finding.key) for finding in found) == [
        ("hardcoded-prefix", "gripper_gazebo"),
        ("interface-typo", "hw_interface"),
    ]
