"""A process beside a bring-up, here a shell script."""

from __future__ import annotations

import logging
import os
import signal
import time
from collections.abc import Iterator

import pytest
from processes import Watch, children

from tool0.errors import TransportError
from tool0.server.companion import UNABLE, Companion

pytestmark = pytest.mark.slow  # it starts programs

LONG = 20.0  # [wall s]; only a failing test waits so long
SCRIPT = """echo '{"ready": true}'; sleep 1000 & wait"""


class Shell(Companion):
    title, kind, unavailable = "Shell", "script", TransportError


@pytest.fixture
def companion() -> Iterator[Shell]:
    with Shell("nobody", lambda name: ["sh", "-c", SCRIPT], os.environ) as companion:
        companion._wait_for_report(LONG)
        yield companion


def supervisor(companion: Shell) -> int:
    (found,) = (
        child for child in children(os.getpid()) if companion.pid in children(child)
    )
    return found


def test_it_starts_again_when_its_supervisor_was_killed(
    companion: Shell, caplog: pytest.LogCaptureFixture
) -> None:
    first = companion.pid
    assert first
    watch = Watch([first])
    with caplog.at_level(logging.WARNING):
        os.kill(supervisor(companion), signal.SIGKILL)
        end = time.monotonic() + LONG
        while companion.pid in (first, None):
            assert time.monotonic() < end
            time.sleep(0.01)
    assert "the Shell script ended with status -9; it starts again" in caplog.text
    assert watch.all_ended(LONG)


def test_it_ends_at_once_when_its_supervisor_was_killed(companion: Shell) -> None:
    assert companion.pid
    watch = Watch([companion.pid])
    os.kill(supervisor(companion), signal.SIGKILL)
    start = time.monotonic()
    companion.close()
    assert time.monotonic() - start < 2.0
    assert watch.all_ended(LONG)


def test_what_lacks_something_is_not_started_again(
    caplog: pytest.LogCaptureFixture,
) -> None:
    script = f"""echo '{{"ready": true}}'; echo 'no module lark' >&2; exit {UNABLE}"""
    with (
        caplog.at_level(logging.INFO),
        Shell("nobody", lambda name: ["sh", "-c", script], os.environ) as companion,
    ):
        companion._wait_for_report(LONG)
        companion._thread.join(LONG)
        assert not companion._thread.is_alive()
    (record,) = [entry for entry in caplog.records if entry.levelno == logging.ERROR]
    assert record.getMessage() == (
        "the Shell script ended and is not started again: no module lark"
    )
