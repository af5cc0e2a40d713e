"""Which failed tests are tried again, and how often."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

RIGS = Path(__file__).parents[1] / "rigs"
TEST = """
import os, pytest, signal, subprocess, time

tries = []
ends = []
set_up = {"module": 0, "session": 0}


@pytest.fixture(scope="module")
def fresh():
    set_up["module"] += 1


@pytest.fixture(scope="session")
def kept():
    set_up["session"] += 1


def stand_still():
    resume = f"sleep 1.3; kill -CONT {os.getpid()}"
    subprocess.Popen(["sh", "-c", resume])
    os.kill(os.getpid(), signal.SIGSTOP)
    ends.append(time.monotonic())


def test_in_a_standstill():
    tries.append(0)
    if len(tries) <= 2:
        stand_still()
        raise AssertionError("late")


def test_before_a_standstill():
    stand_still()


def test_after_a_standstill():
    assert time.monotonic() - ends[-1] > 1.0


def test_with_fixtures(fresh, kept):
    raise AssertionError(f"set up {set_up}")
"""


@pytest.mark.slow
@pytest.mark.parametrize(("option", "n_reruns"), [("--reruns=0", 2), ("--reruns=1", 3)])
def test_what_failed_in_standstills_is_tried_again(
    tmp_path: Path, option: str, n_reruns: int
) -> None:
    """Other failures are tried again only as often as the option says.

    The server of a robot refuses motions for a second after a standstill, so the next
    test waits.
    """
    (tmp_path / "test_it.py").write_text(TEST)
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    found = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "standstill", "-rR", option],
        env={**os.environ, "PYTHONPATH": str(RIGS)},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    ).stdout
    assert "RERUN test_it.py::test_in_a_standstill" in found
    assert f"1 failed, 3 passed, {n_reruns} rerun" in found
    n_tries = n_reruns - 1
    assert f"set up {{'module': {n_tries}, 'session': 1}}" in found
