import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tool0.errors import EngineUnavailableError
from tool0.installation.gazebo.host_tools import last_lines, run_host

PARENT = """
from tool0.installation.gazebo.host_tools import run_host
run_host(["sh", "-c", "echo $$ > pid.new; mv pid.new pid; exec sleep 60"])
"""


def is_alive(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"  # one that has ended, and waits to be counted


def wait_until(condition: Callable[[], bool], what: str) -> None:
    deadline = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < deadline, what
        time.sleep(0.01)


@pytest.mark.skipif(shutil.which("setpriv") is None, reason="needs setpriv")
def test_what_runs_ends_when_we_are_killed(tmp_path: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", PARENT], cwd=tmp_path) as parent:
        wait_until((tmp_path / "pid").exists, "the program did not start")
        child = int((tmp_path / "pid").read_text())
        assert is_alive(child)
        parent.kill()
    wait_until(lambda: not is_alive(child), "the program runs on")


def test_returns_what_was_said_and_how_it_ended(tmp_path: Path) -> None:
    looks: list[None] = []
    answer = run_host(
        ["sh", "-c", "pwd; echo oops >&2; sleep 0.3; exit 3"],
        folder=tmp_path,
        while_running=lambda: looks.append(None),
    )
    assert (answer.stdout, answer.stderr) == (f"{tmp_path.resolve()}\n", "oops\n")
    assert answer.returncode == 3
    assert looks


def test_a_program_that_is_not_there_is_named() -> None:
    with pytest.raises(EngineUnavailableError, match="no program 'no-such-program'"):
        run_host(["no-such-program"])


def test_shows_the_last_lines_that_are_not_empty() -> None:
    assert last_lines("a\n\nb\nc\n\n", 2) == "  b\n  c"
