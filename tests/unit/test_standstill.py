"""Which failures the tests without other programs try again."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

RIGS = Path(__file__).parents[1] / "rigs"
TEST = """
import os, signal, subprocess

tries = []


def test_in_a_standstill():
    tries.append(0)
    if len(tries) == 1:
        resume = f"sleep 1.3; kill -CONT {os.getpid()}"
        subprocess.Popen(["sh", "-c", resume])
        os.kill(os.getpid(), signal.SIGSTOP)
        raise AssertionError("late")


def test_without_one():
    raise AssertionError("wrong")
"""


@pytest.mark.slow
def test_only_what_failed_in_a_standstill_is_tried_again(tmp_path: Path) -> None:
    folder = tmp_path / "tests/unit"
    folder.mkdir(parents=True)
    (folder / "test_it.py").write_text(TEST)
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    found = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "standstill", "-rR", "tests/unit"],
        env={**os.environ, "PYTHONPATH": str(RIGS)},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    ).stdout
    assert "RERUN tests/unit/test_it.py::test_in_a_standstill" in found
    assert "1 failed, 1 passed, 1 rerun" in found
