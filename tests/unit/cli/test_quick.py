from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tool0.cli.quick import read_bringup

from tool0.cli.options import BringupOptions
from tool0.cli.parsing import parse

WORDS = st.sampled_from(
    ["none", "5", "-1", "0.5", "json", "a.yaml", "elbow_joint=1", "None", "a b", ""]
)
OPTIONS = st.sampled_from(
    [
        "--arm",
        "--gripper",
        "--robot",
        "--args",
        "--mount-xyz",
        "--meshes",
        "--safety-limits",
        "--no-safety-limits",
        "--safety-pos-margin",
        "--controllers-file",
        "--controllers",
        "--stopped-controllers",
        "--initial-pose",
        "--scene",
        "--engine",
        "--paused",
        "--no-realtime",
        "--speed",
        "--duration",
        "--headless",
        "--summary",
        "--no-remote",
        "--name",
        "--no-name",
        "--panel-host",
        "--panel-port",
        "--open",
        "--no-open",
        "--help",
        "--wrong",
        "positional",
    ]
)
LINES = st.lists(st.tuples(OPTIONS, st.lists(WORDS, max_size=2)), max_size=3).map(
    lambda groups: [word for option, words in groups for word in (option, *words)]
)


def slowly(arguments: list[str]) -> BringupOptions:
    return parse(BringupOptions, "bringup", arguments, flag_pairs=True)


@settings(max_examples=60, deadline=None)
@given(LINES)
def test_what_it_reads_tyro_reads_alike(arguments: list[str]) -> None:
    quick = read_bringup(arguments)
    if quick is not None:
        assert quick == slowly(arguments)


@pytest.mark.parametrize(
    "line",
    [
        "",
        "--headless --duration 5 --no-realtime --summary json",
        "--controllers-file a.yaml --controllers-file b.yaml --gripper none",
        "--robot my.urdf.xacro --args x:=1 y:=2 --prefix left_ --meshes upstream",
        "--initial-pose elbow_joint=-1.2 finger_joint=0.4 --paused --speed 0.5",
        "--panel-host 0.0.0.0 --panel-port 9000 --no-open",
        "--initial-pose home --safety-limits --safety-pos-margin 0.1 --no-remote",
        "--engine gazebo --world my.world --gazebo-gui",
    ],
)
def test_reads_the_usual_lines_as_tyro_does(line: str) -> None:
    quick = read_bringup(line.split())
    assert quick is not None
    assert quick == slowly(line.split())


@pytest.mark.parametrize(
    "line",
    [
        "--help",
        "--duration",
        "--duration five",
        "--duration 1 2",
        "--duration=5",
        "--summary xml",
        "--engine bullet",
        "--headless yes",
        "--duration 1 --duration 2",
        "--arm ur5 stray",
        "-x",
        "--robot None",
    ],
)
def test_leaves_what_is_in_doubt_to_tyro(line: str) -> None:
    assert read_bringup(line.split()) is None


def test_values_arrive() -> None:
    options = read_bringup(
        ["--controllers-file", "a", "b", "--controllers", "x y", "--duration", "2.5"]
    )
    assert options is not None
    assert options.control.controllers_file == (Path("a"), Path("b"))
    assert options.control.controllers == "x y"
    assert options.simulation.duration == 2.5
