from __future__ import annotations

import pytest
from robot_xml import ARM, DRIVEN, LIMIT, check, joint, link, only, plugin, rules

MIMIC = "libroboticsgroup_upatras_gazebo_mimic_joint_plugin.so"
FOLLOWED = "<joint>hinge</joint><mimicJoint>finger</mimicJoint>"


def follower(name: str, leader: str, parent: str = "arm") -> str:
    mimic = LIMIT + f'<mimic joint="{leader}"/>'
    return joint(name, parent, f"{name}_link", mimic) + link(f"{name}_link")


def gearbox(child: str) -> str:
    return (
        '<gazebo><joint name="g" type="gearbox"><parent>arm</parent>'
        f"<child>{child}</child><gearbox_ratio>1</gearbox_ratio></joint></gazebo>"
    )


def test_a_mimic_joint_that_nothing_holds_in_gazebo() -> None:
    finger = follower("finger", "hinge")
    assert check(ARM, finger) == []  # drawn only
    finding = only(check(DRIVEN, finger), "loose-mimic")
    assert finding.key == "finger"


def test_a_gearbox_holds_it() -> None:
    assert check(DRIVEN, follower("finger", "hinge"), gearbox("finger_link")) == []


def test_a_passive_joint_shall_swing() -> None:
    passive = '<passive_joint name="finger"/>'
    assert check(DRIVEN, follower("finger", "hinge"), passive) == []


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


def test_a_plugin_without_pid_teleports_it() -> None:
    parts = (DRIVEN, follower("finger", "hinge"))
    finding = only(check(*parts, plugin(MIMIC, FOLLOWED)), "teleported-mimic")
    assert finding.key == "finger"
    assert check(*parts, plugin(MIMIC, FOLLOWED + "<hasPID/>")) == []


def test_a_mimic_of_a_joint_that_is_not_there() -> None:
    finding = only(check(ARM, follower("finger", "hing")), "unknown-joint")
    assert 'joint="hinge"' in finding.remedy


@pytest.mark.parametrize(
    ("leaders", "rule"),
    [
        (("finger", "hinge"), "mimic-circle"),
        (("thumb", "finger"), "mimic-circle"),
        (("hinge", "finger"), "mimic-chain"),
    ],
)
def test_a_mimic_of_a_mimic(leaders: tuple[str, str], rule: str) -> None:
    parts = (follower("finger", leaders[0]), follower("thumb", leaders[1]))
    assert rule in rules(check(ARM, *parts))


def test_a_mimic_of_a_fixed_joint() -> None:
    fixed = joint("mount", "arm", "hand", "", "fixed") + link("hand")
    assert rules(check(ARM, fixed, follower("finger", "mount"))) == ["mimic-fixed"]
