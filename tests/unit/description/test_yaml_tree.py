"""YAML that would take too much, and what merges and aliases hold."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tool0.description.yaml_tree import (
    MOST_LEVELS,
    Tree,
    read_mapping,
    read_verbatim,
    text_of,
)
from tool0.errors import ConfigError, SourceLocation

Read = Callable[[Path], Tree]


def read_as_ros(file: Path) -> Tree:
    tree = Tree()
    tree.load(text_of(file), SourceLocation(file, 1))
    return tree


def chained(link: str, n: int = 60) -> str:
    """Return a text in which each line refers to the one before."""
    lines = (f"a{k}: &a{k} {link.format(k - 1)}\n" for k in range(1, n))
    return "a0: &a0 {x: 1}\n" + "".join(lines)


HOSTILE = {
    "open brackets": ("x: " + "[" * 50_000, "nested"),
    "open braces": ("{a: " * 50_000, "nested"),
    "blocks": ("".join("  " * k + "a:\n" for k in range(2_000)), "nested"),
    "lists in a line": ("- " * 50_000, "nested"),
    "an anchor that merges itself": ("a: &a\n  <<: *a\n  b: 1\n", "contains itself"),
    "anchors that merge each other": ("a: &a {b: &b {<<: *a}}\n", "contains itself"),
    "a list in itself": ("a: &a [*a]\n", "contains itself"),
    "merges of merges": (chained("{{<<: [*a{0}, *a{0}]}}"), "aliases of aliases"),
    "aliases of aliases": (chained("[*a{0}, *a{0}]"), "aliases of aliases"),
    "a chain of aliases": (chained("[*a{0}]", 2_000), "nested"),
    "a chain of merges": (chained("{{<<: *a{0}}}", 2_000), "nested"),
    "aliases as a key": (chained("[*a{0}, *a{0}]") + "? *a59\n: 1\n", "must be a text"),
}


@pytest.mark.slow
@pytest.mark.parametrize("read", [read_as_ros, read_verbatim])
@pytest.mark.parametrize("case", HOSTILE)
def test_a_hostile_text_is_refused(case: str, read: Read, tmp_path: Path) -> None:
    text, reason = HOSTILE[case]
    file = tmp_path / "hostile.yaml"
    file.write_text(text)
    with pytest.raises(ConfigError, match=reason) as error:
        read(file)
    assert error.value.location is not None
    assert error.value.location.file == file


@pytest.mark.slow
@pytest.mark.parametrize("option", ["--controllers-file", "--scene", "--robot"])
def test_no_command_crashes_by_brackets(option: str, tmp_path: Path) -> None:
    file = tmp_path / "deep.yaml"
    file.write_text("[" * 50_000)
    if option == "--robot":
        robot = tmp_path / "robot.xacro"
        robot.write_text(
            '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r">'
            f"${{xacro.load_yaml('{file}')}}</robot>"
        )
        file = robot
    done = subprocess.run(
        [sys.executable, "-m", "tool0", "bringup", "--headless", option, str(file)],
        capture_output=True,
        text=True,
        env={**os.environ, "XDG_RUNTIME_DIR": str(tmp_path)},
        timeout=60,
        check=False,
    )
    assert done.returncode == 2, done.stderr
    assert done.stderr.startswith("tool0: error: ")
    assert f"more than {MOST_LEVELS} lists and mappings are nested" in done.stderr


def test_merges_are_read_as_yaml_says(tmp_path: Path) -> None:
    file = tmp_path / "merge.yaml"
    file.write_text(
        "base: &base {p: 1, i: 2}\n"
        "more: &more {<<: *base, i: 3, d: 4}\n"
        "all: {p: 0, <<: [*more, *base]}\n"
    )
    plain = read_mapping(file).plain()
    assert plain == {
        "base": {"p": 1, "i": 2},
        "more": {"p": 1, "i": 3, "d": 4},
        "all": {"p": 0, "i": 3, "d": 4},
    }


@pytest.mark.parametrize("text", ["- 1", "7", "a: 1\na: 2"])
def test_a_mapping_has_each_key_once(text: str, tmp_path: Path) -> None:
    file = tmp_path / "own.yaml"
    file.write_text(text)
    with pytest.raises(ConfigError, match=r"own\.yaml"):
        read_mapping(file)
