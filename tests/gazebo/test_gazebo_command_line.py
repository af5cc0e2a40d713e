"""``tool0`` drives a robot in Gazebo as it does one in MuJoCo."""

import json
import os
import signal
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import pytest
from in_gazebo import PATIENCE
from processes import Watch, descendants, program
from served import use_folder

from tool0.cli import FAILED, OK, main

Capture = pytest.CaptureFixture[str]


class Bringup:
    """``tool0 bringup --engine gazebo`` in a process of its own."""

    def __init__(self) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tool0", "bringup", "--engine=gazebo", "--no-open"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert self.process.stdout is not None
        self.greeting = []
        for line in self.process.stdout:
            self.greeting.append(line.strip())
            if line.startswith("Ctrl-C"):
                break
        self.server = next(
            pid for pid in descendants(self.process.pid) if "gzserver" in program(pid)
        )

    def end(self) -> tuple[int, str, str]:
        """Wait until it ends; return its status and what it printed at last."""
        out, error = self.process.communicate(timeout=PATIENCE)
        return self.process.returncode, out, error


@pytest.fixture
def running(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bringup]:
    use_folder(monkeypatch, tmp_path)
    bringup = Bringup()
    yield bringup
    bringup.process.kill()
    bringup.process.communicate()


def state(capsys: Capture) -> dict[str, dict[str, float]]:
    capsys.readouterr()
    assert main(["state", "--json"]) == OK
    found: dict[str, dict[str, float]] = json.loads(capsys.readouterr().out)
    return found


def test_it_is_driven_from_another_terminal(running: Bringup, capsys: Capture) -> None:
    assert running.greeting[0].startswith("ur5 + 2f85 is up in gazebo: 7 driven joints")
    (url,) = (line[7:] for line in running.greeting if line.startswith("Panel: "))
    with urllib.request.urlopen(url, timeout=PATIENCE) as page:
        assert b"<!doctype html>" in page.read()
    assert main(["move", "--joints", "elbow_joint=1.4", "--duration", "0.5"]) == OK
    assert main(["grip", "--opening", "0.03"]) == OK
    position = state(capsys)["position"]
    assert position["elbow_joint"] == pytest.approx(1.4, abs=0.02)
    assert position["right_finger_joint"] == pytest.approx(
        position["finger_joint"], abs=1e-3
    )
    assert main(["pause"]) == OK
    held = state(capsys)
    assert main(["step", "10"]) == OK
    later = state(capsys)
    assert later["time"] == pytest.approx(held["time"] + 0.010)
    assert main(["reset"]) == OK
    assert state(capsys)["time"] == 0.0
    assert main(["resume"]) == OK
    assert main(["estop"]) == OK
    assert main(["move", "--joints", "elbow_joint=1.2", "--duration", "0.5"]) == FAILED
    assert "the emergency stop is engaged" in capsys.readouterr().err


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGHUP])
def test_a_signal_ends_both(running: Bringup, number: signal.Signals) -> None:
    watch = Watch([running.server])
    running.process.send_signal(number)
    status, out, error = running.end()
    assert status == OK
    assert "s simulated in" in out
    assert error == ""
    assert watch.all_ended(0.0)


def test_it_ends_when_its_gazebo_does(running: Bringup) -> None:
    os.kill(running.server, signal.SIGKILL)
    status, _, error = running.end()
    assert status == FAILED
    assert error.startswith("tool0: error: gzserver is gone, killed by SIGKILL")
