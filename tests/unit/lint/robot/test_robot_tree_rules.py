from __future__ import annotations

from robot_xml import ARM, check, joint, link, only, root_of, rules

from tool0.description.xml_source import parse_text
from tool0.lint.robot_file import robot_findings


def test_a_good_robot_is_silent() -> None:
    assert check(ARM) == []


def test_a_link_defined_twice_names_both_places() -> None:
    found = check(ARM, link("base_link"), joint("f", "arm", "base_link"), "<link/>")
    assert rules(found) == ["unnamed"]
    found = check(
        ARM, joint("f", "arm", "base_link"), link("base_link"), link("base_link")
    )
    finding = only(found, "duplicate-link")
    assert finding.location.line == 5
    assert "<string>:4" in finding.message
    assert "tool0" in finding.remedy


def test_a_joint_defined_twice() -> None:
    found = check(ARM, joint("hinge", "arm", "hand"), link("hand"))
    assert "duplicate-joint" in rules(found)


def test_a_gripper_attached_to_a_name_without_its_prefix() -> None:
    finding = only(
        check(
            link("world", ""),
            joint("hinge", "world", "left_tool0"),
            link("left_tool0"),
            joint("mount", "tool0", "gripper", "", "fixed"),
            link("gripper"),
        ),
        "unknown-link",
    )
    assert finding.location.line == 5
    assert "'tool0'" in finding.message
    assert 'link="left_tool0"' in finding.remedy


def test_a_misspelt_child_is_one_finding_not_two_roots_besides() -> None:
    found = check(ARM, joint("mount", "arm", "hnad"), link("hand"))
    assert rules(found) == ["unknown-link"]


def test_a_joint_without_parent() -> None:
    part = '<joint name="j" type="fixed"><child link="hand"/></joint>'
    assert "parent" in only(check(ARM, part, link("hand")), "unknown-link").message


def test_a_link_with_two_parents() -> None:
    found = check(
        ARM, link("hand"), joint("a", "arm", "hand"), joint("b", "arm", "hand")
    )
    finding = only(found, "two-parents")
    assert finding.location.line == 5
    assert "<string>:4" in finding.message


def test_two_roots() -> None:
    finding = only(check(ARM, link("lonely")), "two-roots")
    assert finding.key == "lonely"
    assert finding.location.line == 3


def test_no_links() -> None:
    assert rules(check("")) == ["no-root"]


def test_a_loop() -> None:
    found = check(
        ARM, link("a"), link("b"), joint("ab", "a", "b"), joint("ba", "b", "a")
    )
    finding = only(found, "loop")
    assert "'ab'" in finding.message
    assert "'ba'" in finding.message


def test_a_loop_of_all_links_has_no_root() -> None:
    found = check(link("a"), link("b"), joint("ab", "a", "b"), joint("ba", "b", "a"))
    assert set(rules(found)) == {"no-root", "loop"}


def test_a_robot_without_a_name() -> None:
    root = parse_text(f"<robot>{ARM}</robot>").documentElement
    finding = only(list(robot_findings(root)), "unnamed")  # type: ignore[arg-type]
    assert finding.key == "<robot>"


def test_a_flood_of_findings_is_cut_and_says_so() -> None:
    found = list(robot_findings(root_of(ARM, *(link("arm") for _ in range(200)))))
    assert len(found) == 51
    assert found[-1].message.startswith("and more")
