"""From words to the configuration values of a bring-up."""

import inspect
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import get_type_hints

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import tool0
from tool0.cli.options import READERS, BringupOptions, RunOptions
from tool0.cli.parsing import (
    assignments,
    gathered,
    joint_values,
    parse,
    parse_quickly,
)
from tool0.errors import ConfigError

CONFIGS = {
    "description": tool0.DescriptionConfig,
    "control": tool0.ControlConfig,
    "simulation": tool0.SimulationConfig,
}
PYTHON_ONLY = {"engine_options", "cameras"}
WORDS = st.sampled_from(
    ["none", "5", "-1", "0.5", "json", "a.yaml", "elbow_joint=1", "None", "a b", ""]
)
NAMES = [
    item.name.replace("_", "-")
    for kind in get_type_hints(BringupOptions).values()
    for item in fields(kind)
]
OPTIONS = st.sampled_from(
    [
        *(f"--{name}" for name in NAMES),
        *("--no-safety-limits", "--no-realtime", "--no-remote", "--no-name"),
        *("--help", "--wrong", "positional"),
    ]
)
LINES = st.lists(st.tuples(OPTIONS, st.lists(WORDS, max_size=2)), max_size=3).map(
    lambda groups: [word for option, words in groups for word in (option, *words)]
)


def quickly(words: list[str]) -> BringupOptions | None:
    return parse_quickly(BringupOptions, words, READERS)


def by_tyro(words: list[str]) -> BringupOptions:
    return parse(BringupOptions, "bringup", words, READERS)


def outcome(parser: Callable[[], BringupOptions | None]) -> object:
    try:
        return parser()
    except ConfigError as error:
        return str(error)
    except SystemExit:
        return "refused"


def test_every_keyword_of_bringup_is_a_value_or_a_field_of_one() -> None:
    names = [item.name for kind in CONFIGS.values() for item in fields(kind)]
    assert len(names) == len(set(names))
    assert set(inspect.signature(tool0.bringup).parameters) <= {*names, *CONFIGS}


def test_every_field_is_an_option_and_has_help(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(SystemExit):
        by_tyro(["--help"])
    help_text = capsys.readouterr().out
    for kind in CONFIGS.values():
        for item in fields(kind):
            option = f"--{item.name.replace('_', '-')}"
            assert (f"{option} " in help_text or f"{option}," in help_text) == (
                item.name not in PYTHON_ONLY
            )


def test_without_options_nothing_is_given() -> None:
    options = quickly([])
    assert options == BringupOptions()
    for name, kind in CONFIGS.items():
        assert getattr(options, name) == kind()
    assert options.full_simulation() == tool0.SimulationConfig()


@settings(max_examples=60, deadline=None)
@given(LINES)
def test_the_quick_parser_agrees_with_tyro(words: list[str]) -> None:
    assert outcome(lambda: quickly(words)) in (None, outcome(lambda: by_tyro(words)))


@pytest.mark.parametrize(
    "line",
    [
        "",
        "--headless --duration 5 --no-realtime --summary json",
        "--controllers-file a.yaml --controllers-file b.yaml --gripper none",
        "--robot my.urdf.xacro --args x:=1 y:=2",
        "--prefix left_ --meshes upstream --mount-xyz 0 0 0.1",
        "--initial-pose elbow_joint=-1.2 finger_joint=0.4 --paused --speed 0.5",
        "--panel-host 0.0.0.0 --panel-port 9000 --no-open",
        "--initial-pose home --safety-limits --safety-pos-margin 0.1 --no-remote",
        "--engine gazebo --world my.world --gazebo-gui",
        "--ros1 --ns left --tf-pub-rate 50",
    ],
)
def test_the_quick_parser_reads_the_usual_lines(line: str) -> None:
    options = quickly(line.split())
    assert options is not None
    assert options == by_tyro(line.split())


@pytest.mark.parametrize(
    "line",
    [
        *("--help", "-x", "--arm ur5 stray", "--robot None", "--engine-options x"),
        *("--duration", "--duration five", "--duration 1 2", "--duration=5"),
        *("--duration 1 --duration 2", "--summary xml", "--headless yes"),
        "--mount-xyz 1 2",
    ],
)
def test_the_quick_parser_leaves_doubtful_lines_to_tyro(line: str) -> None:
    assert quickly(line.split()) is None


def test_values_arrive() -> None:
    words = ["--controllers-file", "a", "b", "--controllers", "x y", "--scene", "s"]
    more = "--args a:=b:=c empty:= --initial-pose a=1 b=-2.5 --mount-xyz 0 0 -0.1"
    options = by_tyro([*words, *more.split()])
    assert options.control == tool0.ControlConfig(
        controllers_file=(Path("a"), Path("b")),
        controllers="x y",
        initial_pose={"a": 1.0, "b": -2.5},
    )
    assert options.description == tool0.DescriptionConfig(
        args={"a": "b:=c", "empty": ""}, mount_xyz=(0.0, 0.0, -0.1)
    )
    assert options.simulation.scene == Path("s")
    assert by_tyro(["--initial-pose", "home"]).control.initial_pose == "home"


def test_options_of_an_engine_get_its_own_names() -> None:
    options = quickly(["--engine", "gazebo", "--world", "a.world", "--gazebo-gui"])
    assert options is not None
    assert options.full_simulation() == tool0.SimulationConfig(
        engine="gazebo", engine_options={"world": Path("a.world"), "gui": True}
    )


@pytest.mark.parametrize(
    "words",
    [("a",), ("=1",), ("a=",), ("a=x",), ("a=nan",), ("a=inf",), ("a=1", "a=2")],
)
def test_wrong_joint_values_name_the_option(words: tuple[str, ...]) -> None:
    with pytest.raises(ConfigError) as error:
        joint_values(words, "--joints")
    assert "--joints" in str(error.value)


def test_an_argument_may_hold_the_sign_and_be_empty() -> None:
    words = ("a:=b:=c", "empty:=")
    assert assignments(words, ":=", "--args") == {"a": "b:=c", "empty": ""}


@pytest.mark.parametrize("duration", [-1.0, float("nan"), float("inf")])
def test_a_wrong_duration_is_refused(duration: float) -> None:
    with pytest.raises(ConfigError) as error:
        RunOptions(duration=duration)
    assert "--duration" in str(error.value)


def test_repeated_options_are_gathered_in_order() -> None:
    line = "--args a:=1 --arm x --args b:=2 c:=3 --args=d:=4 --arm y"
    expected = "--args a:=1 b:=2 c:=3 d:=4 --arm x --arm y"
    assert " ".join(gathered(line.split())) == expected
    assert gathered(["verb", "--name", "x"]) == ["verb", "--name", "x"]
