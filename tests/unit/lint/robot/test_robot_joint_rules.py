from __future__ import annotations

import pytest
from robot_xml import (
    ARM,
    DRIVEN,
    INERTIAL,
    LIMIT,
    check,
    joint,
    link,
    only,
    rules,
)

HAND = link("hand")


def with_joint(inside: str, type: str = "revolute") -> list[str]:
    return rules(check(ARM, joint("wrist", "arm", "hand", inside, type), HAND))


@pytest.mark.parametrize(
    ("inside", "type", "rule"),
    [
        (LIMIT, "revolut", "unknown-joint-type"),
        ("", "revolute", "no-limit"),
        ("", "prismatic", "no-limit"),
        ('<limit lower="0" upper="1" effort="1"/>', "revolute", "no-limit"),
        ('<limit velocity="1"/>', "continuous", "no-limit"),
        (LIMIT.replace('"-1"', '"2"'), "revolute", "limits-swapped"),
        ('<limit effort="1" velocity="1"/>', "prismatic", "no-range"),
        ('<axis xyz="0 0 0"/>' + LIMIT, "revolute", "zero-axis"),
        (LIMIT.replace('"2"', '"180"'), "revolute", "absurd-velocity"),
        (LIMIT.replace('"10"', '"ten"'), "revolute", "not-a-number"),
        (LIMIT.replace('"10"', '"nan"'), "revolute", "not-a-number"),
        ('<origin xyz="0,0,1"/>' + LIMIT, "revolute", "not-a-number"),
        ('<origin xyz="0 0"/>' + LIMIT, "revolute", "not-a-number"),
        (LIMIT.replace('"10"', '"${e}"'), "revolute", "not-a-number"),
    ],
)
def test_a_joint_that_is_wrong(inside: str, type: str, rule: str) -> None:
    assert with_joint(inside, type) == [rule]


@pytest.mark.parametrize(
    ("inside", "type"),
    [
        (LIMIT, "revolute"),
        ('<limit lower="0" upper="1e-1" effort="1" velocity="1"/>', "prismatic"),
        ("", "continuous"),
        (LIMIT.replace('"1"', '"1e+16"'), "revolute"),
        ('<limit effort="1" velocity="300"/>', "continuous"),
        ("", "fixed"),
        ("", "floating"),
        (LIMIT.replace('"10"', '"0"'), "revolute"),  # nothing drives it
    ],
)
def test_a_joint_that_is_right(inside: str, type: str) -> None:
    assert with_joint(inside, type) == []


@pytest.mark.parametrize("what", ["effort", "velocity"])
def test_a_driven_joint_without_power(what: str) -> None:
    powerless = LIMIT.replace(f'{what}="', f'{what}="0" was="')
    finding = only(check(DRIVEN.replace(LIMIT, powerless)), "no-power")
    assert what in finding.message


def test_expressions_are_to_be_expanded_by_xacro() -> None:
    finding = only(check(ARM.replace('"-1"', '"${a}"')), "not-a-number")
    assert "xacro" in finding.remedy


LIGHT = INERTIAL.replace('mass value="1"', 'mass value="0.05"').replace("0.01", "2e-5")
PAD = (
    '<collision><origin xyz="0 0 0.04"/><geometry><box size="0.02 0.02 0.02"/>'
    "</geometry></collision>"
)


def finger(effort: str, inertial: str = LIGHT, type: str = "revolute") -> str:
    limit = LIMIT.replace('effort="10"', f'effort="{effort}"')
    return joint("finger", "arm", "pad", limit, type) + link("pad", inertial + PAD)


def test_a_finger_as_strong_as_an_arm_says_what_force_that_is() -> None:
    finding = only(check(ARM, finger("1000")), "absurd-effort")
    assert finding.severity == "warning"
    # The pad reaches 0.04 + sqrt(3) * 0.01 m: 1000 N·m there are 17 447 N.
    for value in ("1000 N·m", "0.05 kg", "17446 N"):
        assert value in finding.message


def test_a_slide_of_a_thousand_newtons() -> None:
    finding = only(check(ARM, finger("1000", type="prismatic")), "absurd-effort")
    assert "1000 N " in finding.message


@pytest.mark.parametrize(
    "parts",
    [
        finger("50"),
        finger("330", INERTIAL),
        finger("20", type="prismatic"),
        finger("330") + joint("f", "pad", "hand", "", "fixed") + HAND,  # counts too
    ],
)
def test_what_fingers_and_arms_really_have(parts: str) -> None:
    assert check(ARM, parts) == []
