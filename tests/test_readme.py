"""What the README promises."""

import re
import shlex
from pathlib import Path

import pytest
from document import blocks

from tool0.cli import FAILED, OK, main
from tool0.cli.options import READERS, BringupOptions
from tool0.cli.parsing import parse

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def texts(language: str) -> list[str]:
    found = blocks(ROOT / "README.md")
    return [block.text for block in found if block.language == language]


def tool0_lines() -> list[list[str]]:
    text = "\n".join(texts("")).replace("\\\n", " ")
    found = re.findall(r"^(?:\.venv/bin/)?tool0 (.*)$", text, re.MULTILINE)
    return [shlex.split(line, comments=True) for line in found]


def test_the_python_block_runs(capsys: pytest.CaptureFixture[str]) -> None:
    (program,) = texts("python")
    exec(compile(program, "README.md", "exec"), {})
    printed = capsys.readouterr().out
    assert "status=SUCCEEDED" in printed
    time, elbow = map(float, printed.splitlines()[-1].split())
    assert time > 3.0
    assert elbow == pytest.approx(1.4, abs=0.02)


@pytest.mark.parametrize("line", tool0_lines(), ids=" ".join)
def test_every_command_line_is_understood(
    line: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    command, *arguments = line
    if command == "bringup":
        parse(BringupOptions, command, arguments, READERS)
        return
    if command == "gazebo":  # understood, it gets no further than to the keys
        line = [*line, "--private", "--keyring", "/absent.gpg"]
        assert main(line) == FAILED
        assert "/absent.gpg" in capsys.readouterr().err
        return
    if command == "ros1":  # understood, it says what it would do, or why it cannot
        assert main([*line, "--dry-run"]) in (OK, FAILED)
        return
    if command == "demo":  # understood, it refuses to pick nothing
        assert main([*line, "--n", "0"]) == FAILED
        assert "--n must be 1 or more" in capsys.readouterr().err
        return
    # Nobody serves this name, so a line that is understood ends right there.
    assert main([command, *arguments, "--name", "readme-test"]) == FAILED
    assert "no bringup named 'readme-test'" in capsys.readouterr().err


def test_the_formula_of_the_page_is_the_gripper_s() -> None:
    """docs/reference/gripper.md writes numbers that live in the gripper's YAML."""
    from tool0.description.loading import assemble
    from tool0.description.model import RotaryOpening

    text = (ROOT / "docs/reference/gripper.md").read_text(encoding="utf-8")
    (gripper,) = assemble().model.grippers
    law = gripper.law
    assert isinstance(law, RotaryOpening)
    assert f"{law.pad_offset:.10f}" in text
    assert (
        f"{law.pad_cos:.4f} · cos q \N{MINUS SIGN} {-law.pad_sin:.4f} · sin q" in text
    )
    assert gripper.position(0.0) == pytest.approx(0.8133, abs=5e-5)
    for q, lever in ((0.0, 0.086), (0.4374, 0.110), (0.8133, 0.114)):
        assert gripper.lever(q) == pytest.approx(lever, abs=5e-4)
    low, high = gripper.force
    assert low * gripper.lever(0.0) == pytest.approx(1.7, abs=0.05)
    assert high * gripper.lever(0.8133) == pytest.approx(26.7, abs=0.05)
