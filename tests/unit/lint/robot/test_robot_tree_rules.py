from __future__ import annotations

import pytest
from robot_xml import ARM, check, joint, link, root_of, rules

from tool0.description.xml_source import parse_text
from tool0.lint.robot_file import robot_findings


def test_a_good_robot_is_silent() -> None:
    assert check(ARM) == []


@pytest.mark.parametrize(
    ("parts", "rule", "line", "named"),
    [
        (
            (joint("f", "arm", "base_link"), "<link/>", link("base_link")),
            "unnamed",
            4,
            (),
        ),
        (
            (joint("f", "arm", "base_link"), link("base_link"), link("base_link")),
            "duplicate-link",
            5,
            ("<string>:4", "tool0"),
        ),
        ((joint("mount", "arm", "hnad"), link("hand")), "unknown-link", 3, ("'hnad'",)),
        (
            ('<joint name="j" type="fixed"><child link="hand"/></joint>', link("hand")),
            "unknown-link",
            3,
            ("parent",),
        ),
        (
            (joint("m", "left_arm", "hand", "", "fixed"), link("hand")),
            "unknown-link",
            3,
            ("'left_arm'", 'link="arm"'),
        ),
        (
            (link("hand"), joint("a", "arm", "hand"), joint("b", "arm", "hand")),
            "two-parents",
            5,
            ("<string>:4",),
        ),
        ((link("lonely"),), "two-roots", 3, ("'lonely'",)),
        (
            (link("a"), link("b"), joint("ab", "a", "b"), joint("ba", "b", "a")),
            "loop",
            None,
            ("'ab'", "'ba'"),
        ),
    ],
)
def test_one_fault_of_the_tree_is_one_finding(
    parts: tuple[str, ...], rule: str, line: int | None, named: tuple[str, ...]
) -> None:
    (finding,) = check(ARM, *parts)
    assert finding.rule == rule
    assert line in (None, finding.location.line)
    assert all(name in finding.text for name in named), finding.text


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ((ARM, joint("hinge", "arm", "hand"), link("hand")), {"duplicate-joint"}),
        (("",), {"no-root"}),
        (
            (link("a"), link("b"), joint("ab", "a", "b"), joint("ba", "b", "a")),
            {"no-root", "loop"},
        ),
    ],
)
def test_other_faults_of_the_tree(parts: tuple[str, ...], expected: set[str]) -> None:
    assert set(rules(check(*parts))) >= expected


def test_a_robot_without_a_name() -> None:
    root = parse_text(f"<robot>{ARM}</robot>").documentElement
    (finding,) = robot_findings(root)  # type: ignore[arg-type]
    assert (finding.rule, finding.key) == ("unnamed", "<robot>")


def test_a_flood_of_findings_is_cut() -> None:
    found = list(robot_findings(root_of(ARM, *(link("arm") for _ in range(200)))))
    assert set(rules(found)) == {"duplicate-link"}
    assert len(found) == 51
