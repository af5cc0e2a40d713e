"""Links and joints as a tree, and what Gazebo makes of plugins and mimic joints."""

from __future__ import annotations

import pytest
from robot_xml import (
    ARM,
    DRIVEN,
    LIMIT,
    assert_only,
    check,
    fault,
    joint,
    link,
    only,
    plugin,
    rules,
    transmission,
)

from tool0.description.xml_source import parse_text
from tool0.lint.robot_file import robot_findings

MIMIC = "libroboticsgroup_upatras_gazebo_mimic_joint_plugin.so"
FOLLOWED = "<joint>hinge</joint><mimicJoint>finger</mimicJoint>"
HINGE = ARM + transmission("hinge")
HAND = link("hand")
BASE = joint("f", "arm", "base_link")
LOOP = (link("a"), link("b"), joint("ab", "a", "b"), joint("ba", "b", "a"))


def inside(**parameters: str) -> str:
    return "".join(f"<{name}>{text}</{name}>" for name, text in parameters.items())


def follower(name: str, leader: str, parent: str = "arm") -> str:
    mimic = LIMIT + f'<mimic joint="{leader}"/>'
    return joint(name, parent, f"{name}_link", mimic) + link(f"{name}_link")


def gearbox(child: str) -> str:
    return (
        '<gazebo><joint name="g" type="gearbox"><parent>arm</parent>'
        f"<child>{child}</child><gearbox_ratio>1</gearbox_ratio></joint></gazebo>"
    )


FINGER = follower("finger", "hinge")
NO_PARENT = '<joint name="j" type="fixed"><child link="hand"/></joint>'
TWO_PARENTS = (HAND, joint("a", "arm", "hand"), joint("b", "arm", "hand"))
TWO_BASES = (BASE, link("base_link"), link("base_link"))
LEFT = joint("m", "left_arm", "hand", "", "fixed")
SPACED = plugin(inside="\n" + inside(robotNameSpace="/"))
NO_FINGER = inside(joint="hinge", mimicJoint="finger", hasPID="")
NO_LINK = '<gazebo reference="amr"><mu1>1</mu1></gazebo>'


@pytest.mark.parametrize(
    ("parts", "rule", "line", "named", "severity"),
    [
        fault("unnamed", ARM, BASE, "<link/>", link("base_link"), line=4),
        fault("duplicate-link", ARM, *TWO_BASES, line=5, named="<string>:4"),
        fault("duplicate-link", ARM, *TWO_BASES, line=5, named="tool0"),
        fault("unknown-link", ARM, joint("m", "arm", "hnad"), HAND, named="'hnad'"),
        fault("unknown-link", ARM, NO_PARENT, HAND, line=3, named="parent"),
        fault("unknown-link", ARM, LEFT, HAND, line=3, named="'left_arm'"),
        fault("unknown-link", ARM, LEFT, HAND, line=3, named='link="arm"'),
        fault("two-parents", ARM, *TWO_PARENTS, line=5, named="<string>:4"),
        fault("two-roots", ARM, link("lonely"), line=3, named="'lonely'"),
        fault("loop", ARM, *LOOP, named="'ab', 'ba'"),
        fault("two-plugins", DRIVEN, plugin(), line=3, named="<string>:2"),
        fault("two-plugins", DRIVEN, plugin(inside=inside(robotNamespace="/b"))),
        fault("no-plugin", HINGE, plugin("libgazebo_ros_camera.so"), line=2),
        fault("unread-parameter", HINGE, SPACED, line=4, named="<robotNamespace>"),
        fault("unknown-joint", DRIVEN, plugin(MIMIC, NO_FINGER), named="'finger'"),
        fault("unknown-reference", ARM, NO_LINK, line=3, named='reference="arm"'),
        fault("loose-mimic", DRIVEN, FINGER, named="'finger'"),
        fault("teleported-mimic", DRIVEN, FINGER, plugin(MIMIC, FOLLOWED)),
        fault("unknown-joint", ARM, follower("f", "hing"), named='joint="hinge"'),
    ],
)
def test_one_fault_is_one_finding(
    parts: tuple[str, ...], rule: str, line: int | None, named: str, severity: str
) -> None:
    assert_only(parts, rule, line, named, severity)


@pytest.mark.parametrize(
    "parts",
    [
        (ARM,),
        (DRIVEN, plugin(inside=inside(robotParam="other_description"))),
        (HINGE,),  # another file may add the plugin
        (HINGE, plugin("libgz_ros2_control-system.so", inside(parameters="p.yaml"))),
        (HINGE, plugin("libgazebo_ros2_control.so", inside(parameters="p.yaml"))),
        (HINGE, plugin(inside=inside(robotNamespace="/", controlPeriod="0.001"))),
        (ARM, FINGER),  # drawn only
        (DRIVEN, FINGER, gearbox("finger_link")),
        (DRIVEN, FINGER, '<passive_joint name="finger"/>'),
        (DRIVEN, FINGER, plugin(MIMIC, FOLLOWED + "<hasPID/>")),
    ],
)
def test_what_is_right(parts: tuple[str, ...]) -> None:
    assert check(*parts) == []


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ((ARM, joint("hinge", "arm", "hand"), HAND), {"duplicate-joint"}),
        (("",), {"no-root"}),
        (LOOP, {"no-root", "loop"}),
        ((ARM, plugin("libgazebo_ros_contol.so")), {"unknown-plugin"}),
        ((ARM, plugin("libgazebo_ros_controls.so")), {"unknown-plugin"}),
        ((ARM, follower("f", "f"), follower("t", "hinge")), {"mimic-circle"}),
        ((ARM, follower("f", "t"), follower("t", "f")), {"mimic-circle"}),
        ((ARM, follower("f", "hinge"), follower("t", "f")), {"mimic-chain"}),
        (
            (ARM, joint("m", "arm", "hand", "", "fixed"), HAND, follower("f", "m")),
            {"mimic-fixed"},
        ),
    ],
)
def test_other_faults(parts: tuple[str, ...], expected: set[str]) -> None:
    assert set(rules(check(*parts))) >= expected


def test_a_robot_without_a_name() -> None:
    root = parse_text(f"<robot>{ARM}</robot>").documentElement
    (finding,) = robot_findings(root, spawned=False)  # type: ignore[arg-type]
    assert (finding.rule, finding.key) == ("unnamed", "<robot>")


def test_a_flood_of_findings_is_cut() -> None:
    found = check(ARM, *(link("arm") for _ in range(200)))
    assert set(rules(found)) == {"duplicate-link"}
    assert len(found) == 51


def test_a_robot_in_gazebo_needs_a_controller_manager() -> None:
    assert only(check(HINGE, spawned=True), "no-plugin").severity == "warning"


def test_a_gearbox_between_bodies_that_are_not_there() -> None:
    parts = (DRIVEN, follower("finger", "hinge"))
    assert rules(check(*parts, gearbox("fingerlink"))) == [
        "unknown-link",
        "loose-mimic",
    ]
    pad = joint("f", "finger_link", "pad", "", "fixed") + link("pad")
    finding = check(*parts, pad, gearbox("pad"))[0]
    assert finding.remedy == "write <child>finger_link</child>"
    apart = (
        '<gazebo reference="f"><preserveFixedJoint>true</preserveFixedJoint></gazebo>'
    )
    found = check(*parts, pad, apart, gearbox("pad"))
    assert rules(found) == ["loose-mimic"]  # the finger: the gearbox holds the pad
