from __future__ import annotations

from robot_xml import ARM, INERTIAL, LIMIT, check, joint, link, only

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
    assert "1000 N·m" in finding.message
    assert "0.05 kg" in finding.message
    # The pad reaches 0.04 + sqrt(3) * 0.01 m: 1000 N·m there are 17 447 N.
    assert "17446 N or more" in finding.message


def test_a_slide_of_a_thousand_newtons() -> None:
    finding = only(check(ARM, finger("1000", type="prismatic")), "absurd-effort")
    assert "1000 N on" in finding.message


def test_what_fingers_and_arms_really_have() -> None:
    assert check(ARM, finger("50")) == []
    assert check(ARM, finger("330", INERTIAL)) == []
    assert check(ARM, finger("20", type="prismatic")) == []


def test_what_hangs_on_a_joint_counts() -> None:
    hand = joint("f", "pad", "hand", "", "fixed") + link("hand")
    assert check(ARM, finger("330"), hand) == []
