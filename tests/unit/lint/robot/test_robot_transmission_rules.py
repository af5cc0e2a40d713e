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

from tool0.lint.robot.facts import is_interface, meant_interface

EFFORT = "hardware_interface/EffortJointInterface"


def test_a_driven_robot_is_silent() -> None:
    assert check(DRIVEN) == []
    assert check(DRIVEN, spawned=True) == []


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("hardware/interface/EffortJointInterface", "Effort"),
        ('"hardware_interface/EffortJointInterface"', "Effort"),
        ("hardware_interface/EffortJointInterfce", "Effort"),
        ("hardware_interface::PositionJointInterface", "Position"),
        ("hardware_interfaces/VelocityJointInterface", "Velocity"),
        ("PositonJointInterface", "Position"),
        ("hardware_interface/positionjointinterface", None),
    ],
)
def test_a_misspelt_interface_names_the_right_one(
    written: str, meant: str | None
) -> None:
    found = check(ARM + transmission("hinge", written) + plugin())
    if meant is None:
        assert found
        return
    finding = only(found, "interface-typo")
    assert finding.key == written
    assert finding.remedy == f"write hardware_interface/{meant}JointInterface"
    assert "'hinge'" in finding.message


@pytest.mark.parametrize(
    "written", ["EffortJointInterface", "hardware_interface/VelocityJointInterface"]
)
def test_an_interface_with_or_without_its_package(written: str) -> None:
    assert is_interface(written)
    assert meant_interface(written)
    assert check(ARM + transmission("hinge", written) + plugin()) == []


def test_an_interface_of_a_robots_own_driver_is_a_warning_unless_simulated() -> None:
    own = ARM + transmission("hinge", "franka_hw/FrankaPoseCartesianInterface")
    finding = only(check(own + plugin()), "unknown-interface")
    assert finding.severity == "warning"
    simulator = "<robotSimType>franka_gazebo/FrankaHWSim</robotSimType>"
    assert check(own + plugin(inside=simulator)) == []


def test_a_macros_typo_is_told_once_for_all_its_joints() -> None:
    parts = [link("world", "")]
    wrong = ""
    for name in "abc":
        parts += [joint(name, "world", f"link_{name}"), link(f"link_{name}")]
        wrong += transmission(name, "hardware/interface/EffortJointInterface")
    finding = only(check(*parts, wrong, plugin()), "interface-typo")
    assert "'a', 'b', 'c'" in finding.message


HAND = link("hand")
MIMIC = joint("finger", "arm", "hand", LIMIT + '<mimic joint="hinge"/>') + HAND
TWO = f"{EFFORT}</hardwareInterface><hardwareInterface>PositionJointInterface"


WRIST = joint("wrist", "arm", "hand") + HAND
FIXED = joint("m", "arm", "hand", "", "fixed") + HAND
BOTH = ARM + transmission("hinge", TWO) + plugin()


@pytest.mark.parametrize(
    ("parts", "rule", "line", "named", "severity"),
    [
        fault("unknown-joint", DRIVEN, transmission("hing"), named='name="hinge"'),
        fault("unknown-joint", DRIVEN, FIXED, transmission("m"), named="'m'"),
        fault("no-transmission", DRIVEN, WRIST, named="'wrist'", severity="warning"),
        fault("two-transmissions", DRIVEN, transmission("hinge"), named="<string>:2"),
        fault("driven-mimic", DRIVEN, MIMIC, transmission("finger"), named="'finger'"),
        fault("two-interfaces", BOTH, severity="warning"),
    ],
)
def test_one_fault_is_one_finding(
    parts: tuple[str, ...], rule: str, line: int | None, named: str, severity: str
) -> None:
    assert_only(parts, rule, line, named, severity)


def test_joints_that_need_no_transmission() -> None:
    caster = joint("wheel", "arm", "hand", "", "continuous") + HAND
    assert check(DRIVEN, caster) == []
    wheel = joint("wheel", "arm", "hand") + HAND
    assert check(ARM, wheel) == []
    drive = plugin("libgazebo_ros_drive.so", "<leftJoint>wheel</leftJoint>")
    assert check(DRIVEN, wheel, drive) == []


@pytest.mark.parametrize(
    ("type", "severity"),
    [
        ("transmission_interface/SimpelTransmission", "error"),
        ("SimpleTransmission", "error"),
        ("transmission_interface/DifferentialTransmission", "warning"),
        ("transmission_interface/HalfDifferentialTransmission", "warning"),
    ],
)
def test_another_type_of_transmission(type: str, severity: str) -> None:
    found = check(ARM + transmission("hinge", type=type) + plugin())
    finding = only(found, "unknown-transmission")
    assert finding.severity == severity
    assert "SimpleTransmission" in finding.remedy


def test_the_transmissions_of_a_pr2_are_not_those_of_ros_control() -> None:
    old = '<transmission name="t" type="pr2_mechanism_model/SimpleTransmission"/>'
    assert check(DRIVEN, old) == []


@pytest.mark.parametrize(
    "transmission",
    [
        transmission("hinge", actuator=""),
        transmission("hinge", type=""),
        '<transmission name="t"><type>transmission_interface/SimpleTransmission'
        '</type><joint name="hinge"/><actuator name="m"/></transmission>',
        transmission("hinge").replace('name="hinge_trans"', ""),
    ],
)
def test_a_transmission_that_is_not_complete(transmission: str) -> None:
    found = check(ARM + transmission + plugin())
    assert rules(found) == ["incomplete-transmission"]


def test_a_robot_may_have_a_driver_that_needs_no_transmission() -> None:
    assert check(ARM, WRIST, spawned=None) == []
    assert check(ARM, WRIST, spawned=False) == []
