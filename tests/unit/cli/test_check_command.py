"""``tool0 check`` as a person or CI calls it."""

import json
from pathlib import Path

import pytest

from tool0.cli import main

GOOD = "arm:\n  type: effort_controllers/JointEffortController\n  joint: elbow_joint\n"
BAD = GOOD.replace("joint:", "jont:")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "c.yaml"


def test_a_good_file_passes(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file.write_text(GOOD, encoding="utf-8")
    assert main(["check", str(file)]) == 0
    assert capsys.readouterr().out == "no errors, no warnings in 1 file\n"


def test_a_bad_file_fails_with_place_reason_and_remedy(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file.write_text(BAD, encoding="utf-8")
    assert main(["check", str(file)]) == 1
    first, remedy, *_ = capsys.readouterr().out.splitlines()
    assert first.startswith(f"{file}:3: error: arm/jont: JointEffortController does")
    assert first.endswith("[unread-key]")
    assert remedy == "    did you mean 'joint'?"


@pytest.mark.slow
def test_what_is_suspicious_fails_only_if_asked_to(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    gains = "  pid: {p: 1, i: 1}\n"
    text = GOOD.replace("JointEffortC", "JointPositionC") + gains
    file.write_text(text, encoding="utf-8")
    assert main(["check", str(file)]) == 0
    assert "idle-integral" in capsys.readouterr().out
    assert main(["check", str(file), "--strict"]) == 1


def test_programs_get_json(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file.write_text(BAD, encoding="utf-8")
    assert main(["check", str(file), "--json"]) == 1
    report = json.loads(capsys.readouterr().out)
    assert report["errors"] == len(report["findings"])
    assert report["files"] == [str(file)]
    assert report["findings"][0] == {
        "file": str(file),
        "line": 3,
        "severity": "error",
        "rule": "unread-key",
        "key": "arm/jont",
        "message": "JointEffortController does not read it",
        "remedy": "did you mean 'joint'?",
    }


def test_a_path_that_is_not_there_is_a_mistake(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", str(file)]) == 2
    assert "No such file" in capsys.readouterr().err
    assert main(["check"]) == 2
    assert "PATH ... is missing" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("text", ["a: [1, 2\nb: 3\n", "a:\n\t- 1\n", "[" * 50_000])
def test_yaml_that_cannot_be_parsed_is_an_error_whatever_it_is_about(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "notes.yaml").write_text(text)
    (tmp_path / "several.yaml").write_text("a: 1\n---\nb: !of_another_program 2\n")
    assert main(["check", str(tmp_path)]) == 1
    said = capsys.readouterr().out
    assert "[not-yaml]" in said
    assert "1 error, no warnings in 2 files" in said
