from __future__ import annotations

from pathlib import Path

import pytest
from robot_xml import check_xacro, only, rules

from tool0.description.xml_source import parse_text
from tool0.lint.robot.elements import Tag
from tool0.lint.robot.xacro_source import parameters_of

TYPO = "hardware/interface/EffortJointInterface"


def macro(params: str, body: str, name: str = "m") -> str:
    return f'<xacro:macro name="{name}" params="{params}">{body}</xacro:macro>'


def test_a_typo_in_the_default_of_a_parameter() -> None:
    params = f"prefix transmission_hw_interface:={TYPO}"
    body = '<xacro:n prefix="${prefix}" hw="${transmission_hw_interface}"/>'
    finding = only(check_xacro(macro(params, body)), "interface-typo")
    assert finding.key == "transmission_hw_interface"
    assert finding.remedy == "write hardware_interface/EffortJointInterface"


@pytest.mark.parametrize(
    "part",
    [
        f'<xacro:arg name="hw" default="{TYPO}"/>',
        f'<xacro:property name="hw" value="{TYPO}"/>',
        f'<xacro:arm hw="{TYPO}"/>',
        f"<hardwareInterface>{TYPO}</hardwareInterface>",
        "<hardwareInterface>'hardware_interface/EffortJointInterface'"
        "</hardwareInterface>",
    ],
)
def test_a_typo_wherever_it_is_written(part: str) -> None:
    assert rules(check_xacro(part)) == ["interface-typo"]


def test_interfaces_that_are_right() -> None:
    right = TYPO.replace("hardware/", "hardware_")
    body = "<hardwareInterface>${hw}</hardwareInterface>"
    assert check_xacro(macro(f"hw:='{right}'", body)) == []
    assert check_xacro(f'<xacro:arg name="hw" default="{right}"/>') == []
    assert check_xacro('<xacro:arg name="interface" default="eth0"/>') == []


def test_a_macro_that_hands_on_an_empty_prefix() -> None:
    body = '<link name="${prefix}a"/>\n<xacro:gripper prefix=""/>'
    finding = only(check_xacro(macro("prefix", body, "hand")), "hardcoded-prefix")
    assert finding.key == "hand"
    assert finding.location.line == 3
    assert 'prefix="${prefix}"' in finding.remedy


def test_prefixes_that_are_handed_on() -> None:
    body = '<xacro:gripper prefix="${prefix}"/>'
    assert check_xacro(macro("prefix", body)) == []
    assert check_xacro('<xacro:gripper prefix=""/>') == []  # a top level has none
    assert check_xacro(macro("name", '<xacro:gripper prefix="" n="${name}"/>')) == []
    inner = macro("prefix", '<link name="${prefix}a"/>', "inner")
    assert check_xacro(macro("prefix", inner + body)) == []


def test_a_parameter_that_nothing_uses() -> None:
    body = '<link name="${prefix}a"/>'
    finding = only(check_xacro(macro("prefix length:=1", body)), "unused-parameter")
    assert (finding.key, finding.severity) == ("length", "warning")
    finding = only(check_xacro(macro("prefix *origin", body)), "unused-parameter")
    assert "insert_block" in finding.remedy


def test_parameters_that_are_used() -> None:
    body = '<a b="${2 * length}"/><xacro:insert_block name="origin"/>'
    assert check_xacro(macro("length *origin", body)) == []
    # A macro sees the parameters of the one that calls it.
    outer = macro("length", "<xacro:inner/>", "outer")
    assert check_xacro(outer, macro("", '<a b="${length}"/>', "inner")) == []
    assert check_xacro(outer, macro("length:=^", '<a b="1"/>', "inner")) == []


def test_an_argument_with_two_defaults() -> None:
    first, second = (f'<xacro:arg name="a" default="{n}"/>' for n in "12")
    finding = only(check_xacro(first, second), "duplicate-arg")
    assert finding.location.line == 3
    assert check_xacro(first, first) == []


def test_an_include_that_is_not_there(tmp_path: Path) -> None:
    (tmp_path / "arm_macro.xacro").write_text("<robot/>", "utf-8")
    file = tmp_path / "robot.xacro"

    def include(filename: str, more: str = "") -> list[str]:
        part = f'<xacro:include filename="{filename}" {more}/>'
        return [f"{f.rule}: {f.remedy}" for f in check_xacro(part, file=file)]

    assert include("arm_macro.xacro") == []
    assert include("$(dirname)/arm_macro.xacro") == []
    assert include("$(find tool0_description)/urdf/ur_macro.xacro") == []
    assert include("$(arg file)") == []
    assert include("no_*.xacro") == []
    assert include("gone.xacro", 'optional="true"') == []
    assert include("arm_marco.xacro") == [
        "missing-include: there is 'arm_macro.xacro'; write that"
    ]
    (missing,) = include("$(find tool0_description)/urdf/ur_marco.xacro")
    assert "ur_macro.xacro" in missing
    (unknown,) = include("$(find no_such_package)/a.xacro")
    assert unknown.startswith("unknown-package")


@pytest.mark.parametrize(
    ("params", "expected"),
    [
        ("a b:=1 c:='x y' *d **e f:=^ g:=^|2 h=3", "a b=1 c=x y d e f=^ g=2 h=3"),
        ("\n  a\n  b", "a b"),
        ("", ""),
        (":= a", ""),
    ],
)
def test_parameters_are_read_as_xacro_reads_them(params: str, expected: str) -> None:
    element = parse_text(f'<macro params="{params}"/>').documentElement
    assert element is not None
    element.setAttribute("params", params)  # XML makes a line's end a space
    found = [
        p.name if p.default is None else f"{p.name}={p.default}"
        for p in parameters_of(Tag(element))
    ]
    assert " ".join(found) == expected
