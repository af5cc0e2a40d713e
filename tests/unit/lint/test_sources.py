"""Which files there are, and what they are."""

from pathlib import Path

import pytest
from check_files import write

from tool0.errors import ConfigError
from tool0.lint import sources
from tool0.lint.sources import FileKind, collect, kind_of


@pytest.mark.parametrize(
    ("name", "text", "kind"),
    [
        ("package.xml", "<package/>", FileKind.PACKAGE),
        ("a.yaml", "", FileKind.PARAMETERS),
        ("a.yml", "", FileKind.PARAMETERS),
        ("README.md", "", None),
        ("CMakeLists.txt", "", None),
        ("a.urdf.xacro", "", FileKind.XACRO),
        ("a.launch", "", FileKind.LAUNCH),
        (
            "a.launch.xml",
            "<?xml version='1.0'?><!-- <x> -->\n<launch>",
            FileKind.LAUNCH,
        ),
        ("a.xml", "<!-- --><robot name='r'>", FileKind.URDF),
        ("a.urdf", "", FileKind.URDF),
        ("b.urdf", "<robot xmlns:xacro='x'>", FileKind.XACRO),
        ("world.xml", "<sdf>", None),
        ("a.py", "", None),
    ],
)
def test_kinds(tmp_path: Path, name: str, text: str, kind: FileKind | None) -> None:
    file = tmp_path / name
    file.write_text(text, encoding="utf-8")
    assert kind_of(file) is kind


def test_a_folder_is_searched_but_not_what_was_built(tmp_path: Path) -> None:
    write(
        tmp_path,
        {
            "src/mine/package.xml": "<package><name>own</name></package>",
            "src/mine/a.launch": "<launch/>",
            "src/mine/README.md": "text",
            "src/off/CATKIN_IGNORE": "",
            "src/off/b.launch": "<launch/>",
            "build/c.launch": "<launch/>",
            ".git/d.launch": "<launch/>",
        },
    )
    found = collect([tmp_path, tmp_path / "src"])
    assert [item.path.name for item in found.files] == ["a.launch", "package.xml"]
    assert found.packages == {"own": tmp_path / "src" / "mine"}


def test_what_is_named_must_be_readable(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path, {"a.py": "", "large.launch": "<launch/>"})
    monkeypatch.setattr(sources, "LARGEST", 3)
    for name in ("a.launch", "a.py", "large.launch"):
        with pytest.raises(ConfigError) as error:
            collect([tmp_path / name])
        assert name in str(error.value)
    ((path, why),) = collect([tmp_path]).skipped
    assert (path.name, "3 bytes" in why) == ("large.launch", True)
