"""From words to the configuration values of a bring-up."""

import inspect
import json
import math
import re
from dataclasses import fields
from pathlib import Path

import pytest

import tool0
from tool0.cli.options import READERS, BringupOptions, RunOptions
from tool0.cli.parameters import assignments, joint_values
from tool0.cli.parsing import parse
from tool0.cli.text import json_text
from tool0.errors import ConfigError

CONFIGS = {
    "description": tool0.DescriptionConfig,
    "control": tool0.ControlConfig,
    "simulation": tool0.SimulationConfig,
}
PYTHON_ONLY = {"engine_options", "cameras"}


def read(words: list[str]) -> BringupOptions:
    return parse(BringupOptions, "bringup", words, READERS)


def read_line(line: str) -> BringupOptions:
    return read(line.split())


def test_every_keyword_of_bringup_is_a_value_or_a_field_of_one() -> None:
    names = [item.name for kind in CONFIGS.values() for item in fields(kind)]
    assert len(names) == len(set(names))
    assert set(inspect.signature(tool0.bringup).parameters) <= {*names, *CONFIGS}


def test_every_field_is_an_option_and_has_help(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(SystemExit):
        read(["--help"])
    help_text = capsys.readouterr().out
    for kind in CONFIGS.values():
        for item in fields(kind):
            option = rf"^  --{item.name.replace('_', '-')}\b"
            found = re.search(option, help_text, re.MULTILINE)
            assert (found is not None) == (item.name not in PYTHON_ONLY)


def test_without_options_nothing_is_given() -> None:
    options = read([])
    assert options == BringupOptions()
    for name, kind in CONFIGS.items():
        assert getattr(options, name) == kind()
    assert options.full_simulation() == tool0.SimulationConfig()


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("--duraton 5", "no option --duraton; did you mean --duration?"),
        ("stray", "'stray' is one argument too many"),
        ("--arm ur5 stray", "'stray' is one argument too many"),
        ("--engine-options x", "no option --engine-options"),
        ("--cameras x", "no option --cameras"),
        ("--dur 5", "no option --dur"),
        ("--duration", "--duration: expected 1 argument"),
        ("--duration five", "--duration: 'five' is no number"),
        ("--panel-port 80.5", "--panel-port: '80.5' is no whole number"),
        ("--json --no-summary", "--json and --no-summary exclude each other"),
        ("--headless yes", "'yes' is one argument too many"),
        ("--mount-xyz 1 2", "--mount-xyz: expected 3 arguments"),
        ("--mount-xyz 0 0 1cm", "--mount-xyz: '1cm': 'cm' is not a unit here"),
        ("--mount-rpy 0 0 40mm", "--mount-rpy: '40mm'"),
        ("--initial-pose a=x", "--initial-pose: a='x': need a finite number"),
        ("--initial-pose a=1 a=2", "--initial-pose: 'a' is given twice"),
        ("--args a=1", "--args: 'a=1': write name:=value"),
    ],
)
def test_a_wrong_line_is_refused_with_the_option_and_the_word(
    line: str, said: str
) -> None:
    with pytest.raises(ConfigError, match=re.escape(said)):
        read_line(line)


@pytest.mark.parametrize("option", ["--robot", "--scene", "--controllers-file"])
def test_an_empty_name_of_a_file_is_refused_with_its_option(option: str) -> None:
    with pytest.raises(ConfigError) as error:
        read([option, ""])
    assert str(error.value) == f"{option}: the name of the file is empty; give a file"


def test_values_arrive() -> None:
    words = ["--controllers-file", "a", "b", "--controllers", "x y", "--scene", "s"]
    more = "--args a:=b:=c empty:= --initial-pose a=1 b=-2.5 --mount-xyz 0 0 -0.1"
    options = read([*words, *more.split(), "--duration=5", "--no-realtime", "--paused"])
    assert options.control == tool0.ControlConfig(
        controllers_file=(Path("a"), Path("b")),
        controllers="x y",
        initial_pose={"a": 1.0, "b": -2.5},
    )
    assert options.description == tool0.DescriptionConfig(
        args={"a": "b:=c", "empty": ""}, mount_xyz=(0.0, 0.0, -0.1)
    )
    assert options.simulation == tool0.SimulationConfig(
        scene=Path("s"), realtime=False, paused=True
    )
    assert options.run.duration == 5.0
    assert read_line("--initial-pose home").control.initial_pose == "home"


def test_lengths_and_angles_may_have_units() -> None:
    options = read_line(
        "--base-xyz -40mm 0.5m 1 --base-rpy 0 -90deg 1rad --spawn-z 10mm "
        "--initial-pose a=90deg b=-40mm c=1.5 --safety-pos-margin 1e1deg"
    )
    turned = (0.0, -math.pi / 2, 1.0)
    assert options.description.base_xyz == pytest.approx((-0.04, 0.5, 1.0))
    assert options.description.base_rpy == pytest.approx(turned)
    assert options.description.safety_pos_margin == pytest.approx(math.radians(10.0))
    assert options.simulation.spawn_z == pytest.approx(0.01)
    pose = options.control.initial_pose
    assert pose == pytest.approx({"a": math.pi / 2, "b": -0.04, "c": 1.5})


def test_a_repeated_option_adds_its_values_in_order() -> None:
    options = read_line(
        "--args a:=1 --arm x --args b:=2 c:=3 --args=d:=4 --controllers-file f "
        "--controllers-file g"
    )
    assert options.description.args == {"a": "1", "b": "2", "c": "3", "d": "4"}
    assert options.control.controllers_file == (Path("f"), Path("g"))


def test_options_of_an_engine_get_its_own_names() -> None:
    options = read(["--engine", "gazebo", "--world", "a.world", "--gazebo-gui"])
    assert options.full_simulation() == tool0.SimulationConfig(
        engine="gazebo", engine_options={"world": Path("a.world"), "gui": True}
    )


@pytest.mark.parametrize(
    "words",
    [("a",), ("=1",), ("a=",), ("a=x",), ("a=nan",), ("a=inf",), ("a=1e999",)],
)
def test_wrong_joint_values_are_refused(words: tuple[str, ...]) -> None:
    with pytest.raises(ConfigError) as error:
        joint_values(words)
    assert words[0] in str(error.value).replace("'", "")


def test_an_argument_may_hold_the_sign_and_be_empty() -> None:
    words = ("a:=b:=c", "empty:=")
    assert assignments(words, ":=") == {"a": "b:=c", "empty": ""}


@pytest.mark.parametrize("duration", [-1.0, float("nan"), float("inf")])
def test_a_wrong_duration_is_refused(duration: float) -> None:
    with pytest.raises(ConfigError) as error:
        RunOptions(duration=duration)
    assert "--duration" in str(error.value)


def test_json_is_whole_in_any_encoding() -> None:
    text = json_text({"name": "é·", "limit": math.inf, "pair": (1.0, math.nan)})
    assert text.isascii()
    assert json.loads(text) == {"name": "é·", "limit": None, "pair": [1.0, None]}
