"""Messages and dialogues that the guides quote, in blocks of text with a title."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from document import blocks, says
from served import serving

import tool0
from tool0.cli import main
from tool0.description.catalogue import find_part
from tool0.errors import Tool0Error
from tool0.ur.urscript.program import compile_program

GUIDES = Path(__file__).parents[2] / "docs/how-to"


def text_of(page: str, title: str) -> str:
    (found,) = (b.text for b in blocks(GUIDES / page) if b.title == title)
    return found


WRONG_PROGRAMS = [
    "def pick():\n\n\n  movej([0, 1, 2])\nend",
    "def pick():\n\n\n\n\n\n  moveJ([0, 1, 2, 0, 0, 0])\nend",
    "def pick():\n\n\n\n\n\n\n\n  while True:\n    sync()\nend",
    f"def pick():{11 * chr(10)}  path_offset_enable()\nend",
]


@pytest.mark.parametrize(
    ("program", "message"),
    [*zip(WRONG_PROGRAMS, text_of("urscript.md", "errors").splitlines(), strict=True)],
)
def test_programs_of_urscript_are_refused_so(program: str, message: str) -> None:
    with pytest.raises(Tool0Error) as refused:
        compile_program(program, "pick")
    assert str(refused.value) == message


def test_the_program_with_torques_is_accepted() -> None:
    assert compile_program(text_of("urscript.md", "program"))


WRONG_STEPS = [
    ("[0.5487, 0.1091, 0.0025]", "[1.9, 0.1091, 0.0025]"),
    ("named_pose: home", "named_pose: hmoe"),
]


@pytest.mark.parametrize(
    ("change", "message"),
    [*zip(WRONG_STEPS, text_of("programs.md", "errors").splitlines(), strict=True)],
)
def test_programs_of_steps_are_refused_so(
    change: tuple[str, str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    program = text_of("programs.md", "pick.yaml").replace(*change)
    Path("pick.yaml").write_text(program, encoding="utf-8")
    scene = tool0.SimulationConfig(scene="table_and_bin")
    with tool0.bringup(simulation=scene, realtime=False) as robot, serving(robot):
        assert main(["run", "pick.yaml", "--check"]) != 0
    printed = capsys.readouterr()
    assert says(printed.out + printed.err, message), printed


WRONG_ARMS = [
    ("physical_parameters.yaml", "mass: 2.846", "mass: -2.846"),
    ("joint_limits.yaml", "max_velocity:", "max_velocty:"),
]


@pytest.mark.parametrize(
    ("change", "message"),
    [*zip(WRONG_ARMS, text_of("own-robot.md", "errors").splitlines(), strict=True)],
)
def test_an_arm_is_refused_so(
    change: tuple[str, str, str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    name, right, wrong = change
    monkeypatch.chdir(tmp_path)
    shutil.copytree(find_part("arm", "ur5e").folder, "my_arm")
    file = Path("my_arm", name)
    text = file.read_text(encoding="utf-8")
    assert right in text
    file.write_text(text.replace(right, wrong, 1), encoding="utf-8")
    assert main(["describe", "table", "--arm", "./my_arm"]) != 0
    printed = capsys.readouterr().err
    assert says(printed.replace(f"{tmp_path}/", ""), message), printed
