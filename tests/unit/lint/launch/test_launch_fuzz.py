"""Whatever stands in a launch file, it is read: with findings, not with exceptions."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tool0.lint.launch.argument_flow import argument_flow
from tool0.lint.launch.explanation import contents
from tool0.lint.launch.grammar import ATTRIBUTES
from tool0.lint.launch.reader import read_launch
from tool0.lint.launch.xacro_files import xacro_robots
from tool0.lint.launch_file import commented_rosparams
from tool0.lint.packages import PackageIndex

pytestmark = pytest.mark.slow

DATA = Path(__file__).parents[3] / "data" / "launch" / "src"
SEEDS = [
    (DATA / "quirks" / "launch" / "quirks.launch").read_text(encoding="utf-8"),
    (DATA / "arm_gazebo/launch/inc/control.launch.xml").read_text(encoding="utf-8"),
    (DATA / "arm_gazebo/launch/inc/load_arm.launch.xml").read_text(encoding="utf-8"),
]
WORDS = [
    *("$(arg name)", "$(eval ", "$(find quirks)", "$(dirname)/main.launch", "$(", ")"),
    *("true", "0", "", "~", "/", "'", "ns", "&#10;", "&lt;", "-->", "<!--", "xacro"),
    *('"/>', "<group>", "</group>", "<include", "pass_all_args", "\u00e9", "a:=b"),
]
TAGS = st.sampled_from(sorted(ATTRIBUTES))
VALUES = st.one_of(
    st.sampled_from(WORDS[:12]).filter(lambda word: "<" not in word),
    st.text(st.characters(categories=["L", "N", "P", "S", "Z"]), max_size=20),
    st.builds("$(eval {})".format, st.text("()[]+*'a1 ,.:<", max_size=15)),
    st.builds("$(arg {})".format, st.sampled_from("abc")),
)


def escaped(text: str) -> str:
    for character, entity in (("&", "&amp;"), ("<", "&lt;"), ('"', "&quot;")):
        text = text.replace(character, entity)
    return text


@st.composite
def elements(draw: st.DrawFn, depth: int = 0) -> str:
    """Draw an element of roslaunch with any attributes, and others in it."""
    tag = draw(TAGS)
    names = draw(st.lists(st.sampled_from(sorted(ATTRIBUTES[tag])), unique=True))
    given = "".join(f' {name}="{escaped(draw(VALUES))}"' for name in names)
    inside = draw(st.lists(elements(depth + 1), max_size=2)) if depth < 3 else []
    return f"<{tag}{given}>{''.join(inside)}{escaped(draw(VALUES))}</{tag}>"


def explained(content: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "main.launch")
        file.write_bytes(content)
        packages = PackageIndex({"quirks": DATA / "quirks"})
        launch = read_launch(file, {"a": "1"}, packages)
        robots = xacro_robots(launch, packages)
        assert contents(launch, robots).name == str(file)
        argument_flow(launch, robots)
        list(commented_rosparams(file))


@settings(max_examples=60, deadline=10_000)
@given(st.lists(elements(), max_size=6))
def test_any_elements(found: list[str]) -> None:
    explained(f"<launch>{''.join(found)}</launch>".encode())


@settings(max_examples=100, deadline=10_000)
@given(
    st.sampled_from(SEEDS),
    st.lists(
        st.tuples(st.floats(0, 1), st.integers(0, 30), st.sampled_from(WORDS)),
        max_size=5,
    ),
)
def test_files_that_are_damaged(text: str, cuts: list[tuple[float, int, str]]) -> None:
    for place, length, word in cuts:
        at = int(place * len(text))
        text = text[:at] + word + text[at + length :]
    explained(text.encode())


@settings(max_examples=40, deadline=10_000)
@given(st.binary(max_size=200))
def test_any_bytes(content: bytes) -> None:
    explained(content)
    explained(b"<launch>" + content + b"</launch>")
