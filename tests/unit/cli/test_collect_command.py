"""``tool0 collect`` as a person calls it."""

from __future__ import annotations

import io
import json
import re
from pathlib import Path

import pytest
from data_sets import POLICY
from fake_tasks import WALK

from tool0.cli import FAILED, OK, main
from tool0.cli import collect as command
from tool0.cli.parameters import keywords
from tool0.collect import collecting

pytestmark = pytest.mark.slow

N = 20


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def collected(folder: Path, *words: str, n: int = N) -> int:
    options = f"collect --task {WALK} --episodes {n} --folder {folder}"
    return main([*options.split(), "--workers", "1", "--policy", POLICY, *words])


def test_it_prints_progress_and_a_summary(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert collected(tmp_path / "walk") == OK
    out, error = capsys.readouterr()
    assert out.startswith(f"{tmp_path}/walk: 20 episodes, ")
    assert error.startswith(f"{WALK}: 20/20 episodes, ")
    assert error.count("\n") == 1
    assert "% succeeded" in error


def test_a_terminal_shows_a_bar_with_rate_and_success(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    assert collected(tmp_path / "walk") == OK
    *_, last = terminal.getvalue().split("\r\x1b[K")
    assert last.startswith(f"{'#' * 24} 100 %  {WALK}: 20/20 episodes, ")
    assert "/s, " in last
    assert last.endswith("\n")


def test_programs_get_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--json", "--seed", "3", "--format", "lerobot"]
    words += ["--instruction", "Walk to the middle."]
    assert collected(tmp_path / "walk", *words) == OK
    summary = json.loads(capsys.readouterr().out)
    assert summary["episodes"] == N
    assert summary["folder"] == str(tmp_path / "walk")
    manifest = json.loads((tmp_path / "walk/manifest.json").read_text())
    assert manifest["seed"] == 3
    assert manifest["format"] == "lerobot"
    assert manifest["instruction"] == "Walk to the middle."
    assert manifest["bytes"] == summary["bytes"]


def test_the_folder_has_the_name_of_the_task(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    words = (
        "--episodes 1 --workers 1 --env reward=sparse control_rate=25 image_size=96,64"
    )
    assert main(["collect", "--task", "Reach", *words.split()]) == OK
    manifest = json.loads(Path("Reach/manifest.json").read_text())
    assert manifest["options"] == {
        "reward": "sparse",
        "control_rate": 25,
        "image_size": [96, 64],
    }


@pytest.mark.parametrize(
    ("line", "shown"),
    [
        ("", "--task"),
        ("--task Lift", "--episodes"),
        ("--task Lifd --episodes 3", "did you mean 'Lift'"),
        ("--task Lift --episodes 0", "episodes must be 1 or more"),
        ("--task Lift --episodes many", "no whole number"),
        ("--task Lift --episodes 3 --format csv", "parquet or lerobot"),
        ("--task Lift --episodes 3 --env arm", "name=value"),
        (
            "--task Lift --episodes 3 --env camera=scene,nowhere",
            "no camera 'nowhere'",
        ),
        ("--task Lift --episodes 3 --instruction Lift", "format lerobot"),
        ("--task Lift --episodes 3 --policy nothing.py:x", "No such file"),
        ("--task Lift --episodes 3 --ray 127.0.0.1:1", "no Ray cluster"),
    ],
)
def test_a_wrong_line_is_refused_in_one_line(
    line: str,
    shown: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["collect", *line.split()]) == FAILED
    out, error = capsys.readouterr()
    assert out == ""
    assert error.startswith("tool0: error: ")
    assert error.count("\n") == 1
    assert shown in error


def test_without_a_terminal_there_is_a_line_now_and_then(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(command, "LINE_PERIOD", 0.0)
    monkeypatch.setattr(collecting, "_POLL", 0.01)
    assert collected(tmp_path / "walk") == OK
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) > 1
    assert all(re.match(rf"{WALK}: \d+/20 episodes, [\d.]+/s", line) for line in lines)
    assert lines[-1].startswith(f"{WALK}: 20/20 episodes")


@pytest.mark.parametrize(
    ("word", "value"),
    [
        ("a=96,64", [96, 64]),
        ("a=scene,wrist", ["scene", "wrist"]),
        ('a=["scene"]', ["scene"]),
        ("a=true", True),
        ("a=ur5e", "ur5e"),
        ("a=Lift it, now.", "Lift it, now."),
    ],
)
def test_keywords_are_json_lists_or_texts(word: str, value: object) -> None:
    assert keywords([word]) == {"a": value}
