"""The output of ``--json`` has the keys that docs/reference/cli.md lists."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from json_keys import wrong_keys
from tools.cli_json import element_of, entry_of, has_keys, keys_of, options

import tool0
from tool0.cli import COMMANDS, form_and_readers, main
from tool0.cli.outputs import OUTPUTS
from tool0.cli.parameters import parameters_of
from tool0.description.shapes import Box

PROGRAM = """\
name: home
steps:
  - {kind: move_joint, named_pose: home}
"""
LAUNCH = "<launch><arg name='rate' default='5'/></launch>"

COMMANDS_OF_A_ROBOT = [
    ("state", 0),
    ("wrench", 0),
    ("camera --list", 1),
    ("controllers list", 0),
    ("controllers gains eff_joint_traj_controller", 0),
    ("scene list", 0),
    ("program list", 0),
    ("grip --opening 40mm", 1),
    ("move --joints elbow_joint=1.3 --duration 1", 0),
    ("move --joints elbow_joint=1.4 --check", 2),
    ("move --joints elbow_joint=1.4 --plan --check", 3),
    ("move --joints elbow_joint=1.4 --plan", 1),
    ("run home.yaml --check", 1),
    ("run home.yaml", 0),
]
COMMANDS_OF_FILES = [
    ("describe tree", 0),
    ("describe table", 0),
    ("describe sources", 1),
    ("check wrong.launch home.yaml", 0),
    ("explain wrong.launch", 0),
    ("bringup --headless --no-realtime --no-remote --duration 0.05", 0),
    ("bringup --headless --no-realtime --no-remote --duration 0.05 --record a.mcap", 0),
    ("log a.mcap", 0),
    ("replay a.mcap --simulate", 0),
    ("replay a.mcap --compare", 1),
]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "home.yaml").write_text(PROGRAM)
    (tmp_path / "wrong.launch").write_text(LAUNCH)
    return tmp_path


def require_documented(
    line: str, output: int, capsys: pytest.CaptureFixture[str]
) -> None:
    """Run a command, and compare its keys with those of one documented output."""
    words = line.split()
    main([*words, "--json"])
    out, error = capsys.readouterr()
    assert out, error
    command = words[0]
    two = " ".join(words[:2])
    shape = OUTPUTS[two if two in OUTPUTS else command][output].shape
    assert not wrong_keys(json.loads(out), shape)


@pytest.mark.usefixtures("folder")
def test_commands_of_a_robot(
    robot: tool0.Robot, capsys: pytest.CaptureFixture[str]
) -> None:
    box = Box(size=(0.05, 0.05, 0.05))
    robot.scene.add("box", box, xyz=(0.6, 0.4, 0.03), mass=0.1)
    for line, output in COMMANDS_OF_A_ROBOT:
        require_documented(line, output, capsys)
    robot.pause()
    require_documented("step", 0, capsys)


@pytest.mark.usefixtures("folder")
def test_commands_of_files(capsys: pytest.CaptureFixture[str]) -> None:
    for line, output in COMMANDS_OF_FILES:
        require_documented(line, output, capsys)


def test_a_missing_and_an_unknown_key_are_found() -> None:
    shape = OUTPUTS["step"][0].shape
    assert not wrong_keys({"time": 1.0}, shape)
    assert wrong_keys({}, shape) == [".time"]
    assert wrong_keys({"time": 1.0, "tick": 3}, shape) == [".tick"]


def test_each_command_with_json_is_documented() -> None:
    assert sorted(OUTPUTS) == sorted(_commands_with_json())


def _commands_with_json() -> Iterator[str]:
    for command in COMMANDS:
        form, readers = form_and_readers(command)
        forms = {command: form}
        if isinstance(form, dict):
            forms = {f"{command} {name}": item for name, item in form.items()}
        for words, item in forms.items():
            if any("--json" in each.flags for each in parameters_of(item, readers)):
                yield words


def test_each_key_has_a_meaning() -> None:
    for words, outputs in OUTPUTS.items():
        for output in outputs:
            assert not list(_without_text(output.shape)), words


def _without_text(kind: Any, seen: tuple[Any, ...] = ()) -> Iterator[str]:
    for option in options(kind):
        if option in seen:
            continue
        if has_keys(option):
            for name, key in keys_of(option).items():
                if not key.text:
                    yield name
                yield from _without_text(key.kind, (*seen, option))
        elif (inner := element_of(option)) is not None:
            yield from _without_text(inner, seen)
        elif (entry := entry_of(option)) is not None:
            yield from _without_text(entry[1], seen)
