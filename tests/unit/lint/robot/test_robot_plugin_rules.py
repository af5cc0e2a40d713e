from __future__ import annotations

import pytest
from robot_xml import ARM, DRIVEN, check, only, plugin, rules, transmission

MIMIC = "libroboticsgroup_upatras_gazebo_mimic_joint_plugin.so"


def test_two_controller_managers_name_both_places() -> None:
    finding = only(check(DRIVEN, plugin()), "two-plugins")
    assert finding.location.line == 3
    assert "<string>:2" in finding.message
    other = plugin(inside="<robotNamespace>/b</robotNamespace>")
    assert rules(check(DRIVEN, other)) == ["two-plugins"]


def test_two_controller_managers_of_two_robots() -> None:
    other = plugin(inside="<robotParam>other_description</robotParam>")
    assert check(DRIVEN, other) == []


def test_no_controller_manager_in_a_robot_for_gazebo() -> None:
    robot = ARM + transmission("hinge")
    assert check(robot) == []  # another file may add it
    assert only(check(robot, spawned=True), "no-plugin").severity == "warning"
    assert only(check(robot, plugin("libgazebo_ros_camera.so")), "no-plugin")


@pytest.mark.parametrize(
    "filename",
    ["libgz_ros2_control-system.so", "libgazebo_ros2_control.so"],
)
def test_the_controller_managers_of_ros2(filename: str) -> None:
    parameters = "<parameters>p.yaml</parameters>"
    assert check(ARM, transmission("hinge"), plugin(filename, parameters)) == []


@pytest.mark.parametrize(
    "filename", ["libgazebo_ros_contol.so", "libgazebo_ros_controls.so"]
)
def test_a_misspelt_library(filename: str) -> None:
    assert "unknown-plugin" in rules(check(ARM, plugin(filename)))


def test_a_misspelt_parameter_names_the_right_one() -> None:
    text = "\n<robotNameSpace>/</robotNameSpace>"
    found = check(ARM + transmission("hinge"), plugin(inside=text))
    finding = only(found, "unread-parameter")
    assert finding.location.line == 4
    assert finding.remedy == "write <robotNamespace>"


def test_the_parameters_that_are_read() -> None:
    text = "<robotNamespace>/</robotNamespace><controlPeriod>0.001</controlPeriod>"
    assert check(ARM + transmission("hinge"), plugin(inside=text)) == []


def test_a_mimic_plugin_of_a_joint_that_is_not_there() -> None:
    text = "<joint>hinge</joint><mimicJoint>finger</mimicJoint><hasPID/>"
    finding = only(check(DRIVEN, plugin(MIMIC, text)), "unknown-joint")
    assert finding.key == "finger"


def test_an_extension_of_nothing() -> None:
    part = '<gazebo reference="amr"><mu1>1</mu1></gazebo>'
    finding = only(check(ARM, part), "unknown-reference")
    assert 'reference="arm"' in finding.remedy
