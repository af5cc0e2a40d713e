from __future__ import annotations

from pathlib import Path

import pytest
from robot_xml import ARM, check, joint, link, only, rules

from tool0.description.finding import Finding


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    (tmp_path / "hand.stl").write_bytes(b"")
    return tmp_path


def check_mesh(package: Path, uri: str, scale: str = "") -> list[Finding]:
    mesh = f'<visual><geometry><mesh filename="{uri}" {scale}/></geometry></visual>'
    parts = (ARM, joint("j", "arm", "hand", "", "fixed"), link("hand", mesh * 2))
    return check(*parts, packages={"my_robot": package})


def test_meshes_that_are_there(package: Path) -> None:
    for uri in (
        "package://my_robot/hand.stl",
        f"file://{package}/hand.stl",
        "model://hand/hand.dae",
        "package://tool0_description/meshes/ur5/visual/base_grey.stl",
    ):
        assert check_mesh(package, uri) == []


def test_a_missing_file_names_the_nearest(package: Path) -> None:
    found = check_mesh(package, "package://my_robot/Hand.stl")
    assert "'hand.stl'" in only(found, "unresolved-uri").remedy


def test_a_missing_package_is_another_matter(package: Path) -> None:
    finding = only(check_mesh(package, "package://ur5_x/a.stl"), "unknown-package")
    assert finding.severity == "warning"
    finding = only(check_mesh(package, "package://my_robott/a.stl"), "unknown-package")
    assert (finding.severity, finding.remedy) == ("error", "did you mean 'my_robot'?")


@pytest.mark.parametrize(
    ("uri", "rule"),
    [
        ("", "unresolved-uri"),
        ("$(find my_robot)/hand.stl", "unresolved-uri"),
        ("pakage://my_robot/hand.stl", "unresolved-uri"),
        ("package:/my_robot/hand.stl", "unresolved-uri"),
        ("/nowhere/hand.stl", "unresolved-uri"),
        ("~nobody/hand.stl", "relative-mesh"),
        ("hand.stl", "relative-mesh"),
        ("package:///meshes/hand.stl", "unknown-package"),
        ("package://" + 300 * "a" + "/hand.stl", "unknown-package"),
        ("package://my_robot/" + 5000 * "a" + ".stl", "unresolved-uri"),
        ("model://hand/hand.step", "unsupported-mesh"),
    ],
)
def test_meshes_that_nothing_finds(package: Path, uri: str, rule: str) -> None:
    assert rules(check_mesh(package, uri)) == [rule]


def test_a_scale_of_zero(package: Path) -> None:
    found = check_mesh(package, "package://my_robot/hand.stl", 'scale="1 1 0"')
    assert set(rules(found)) == {"zero-scale"}
