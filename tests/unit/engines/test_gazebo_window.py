import logging
import threading
from pathlib import Path

import pytest

from tool0.engines.gazebo.server import ClientWindow
from tool0.installation.child_process import ChildProcess

TIMEOUT = 20.0


class Starts:
    """Runs a shell's words each time, and counts."""

    def __init__(self, *words: str) -> None:
        self._left = list(words)
        self.enough = threading.Event()
        """That all words were run."""

    def __call__(self) -> ChildProcess:
        words = self._left.pop(0)
        if not self._left:
            self.enough.set()
        return ChildProcess(["sh", "-c", words])


CRASH = "kill -SEGV $$"
STAY = "exec sleep 60"


def wait_for_watchers() -> None:
    """Wait until no thread watches a window any more."""
    for thread in threading.enumerate():
        if thread.name == "gzclient":
            thread.join(TIMEOUT)
            assert not thread.is_alive()


def test_one_that_crashes_is_started_again(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    start = Starts(CRASH, CRASH, STAY)
    window = ClientWindow(start, tmp_path / "log")
    assert start.enough.wait(TIMEOUT)
    window.close()
    wait_for_watchers()
    assert window.process.exit_status is not None
    assert not [r for r in caplog.records if "engines" in r.name]
    window.close()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((CRASH, CRASH, CRASH), "SIGSEGV"),
        (("exit 3",), "exit status 3"),
    ],
)
def test_one_that_cannot_be_kept_is_told_of(
    words: tuple[str, ...],
    told: str,
    tmp_path: Path,
    caplog: pytest.LogCaptureFixture,
) -> None:
    log = tmp_path / "log"
    log.write_text("\x1b[1;31mno luck\x1b[0m\n[Msg] chatter\n")
    window = ClientWindow(Starts(*words), log)
    wait_for_watchers()
    window.close()
    (record,) = (r for r in caplog.records if "engines" in r.name)
    assert record.levelno == logging.WARNING
    first, *lines = record.getMessage().splitlines()
    assert told in first
    assert lines == ["  no luck"]


@pytest.mark.parametrize("words", ["exit 0", "kill -TERM $$"])
def test_one_that_a_person_closes_stays_closed(
    words: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    window = ClientWindow(Starts(words), tmp_path / "log")  # a second start would fail
    wait_for_watchers()
    window.close()
    assert not [r for r in caplog.records if "engines" in r.name]
