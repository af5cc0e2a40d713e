from __future__ import annotations

import pytest
from robot_xml import ARM, DRIVEN, check, only, plugin, rules, transmission

MIMIC = "libroboticsgroup_upatras_gazebo_mimic_joint_plugin.so"
HINGE = ARM + transmission("hinge")


def inside(**parameters: str) -> str:
    return "".join(f"<{name}>{text}</{name}>" for name, text in parameters.items())


@pytest.mark.parametrize(
    ("parts", "rule", "line", "named"),
    [
        ((DRIVEN, plugin()), "two-plugins", 3, "<string>:2"),
        ((DRIVEN, plugin(inside=inside(robotNamespace="/b"))), "two-plugins", 3, ""),
        ((HINGE, plugin("libgazebo_ros_camera.so")), "no-plugin", 2, ""),
        (
            (HINGE, plugin(inside="\n" + inside(robotNameSpace="/"))),
            "unread-parameter",
            4,
            "<robotNamespace>",
        ),
        (
            (
                DRIVEN,
                plugin(MIMIC, inside(joint="hinge", mimicJoint="finger", hasPID="")),
            ),
            "unknown-joint",
            3,
            "'finger'",
        ),
        (
            (ARM, '<gazebo reference="amr"><mu1>1</mu1></gazebo>'),
            "unknown-reference",
            3,
            'reference="arm"',
        ),
    ],
)
def test_one_fault_is_one_finding(
    parts: tuple[str, ...], rule: str, line: int, named: str
) -> None:
    finding = only(check(*parts), rule)
    assert finding.location.line == line
    assert named in finding.text


@pytest.mark.parametrize(
    "parts",
    [
        (DRIVEN, plugin(inside=inside(robotParam="other_description"))),
        (HINGE,),  # another file may add the plugin
        (HINGE, plugin("libgz_ros2_control-system.so", inside(parameters="p.yaml"))),
        (HINGE, plugin("libgazebo_ros2_control.so", inside(parameters="p.yaml"))),
        (HINGE, plugin(inside=inside(robotNamespace="/", controlPeriod="0.001"))),
    ],
)
def test_what_is_right(parts: tuple[str, ...]) -> None:
    assert check(*parts) == []


def test_a_robot_in_gazebo_needs_a_controller_manager() -> None:
    assert only(check(HINGE, spawned=True), "no-plugin").severity == "warning"


@pytest.mark.parametrize(
    "filename", ["libgazebo_ros_contol.so", "libgazebo_ros_controls.so"]
)
def test_a_misspelt_library(filename: str) -> None:
    assert "unknown-plugin" in rules(check(ARM, plugin(filename)))
