"""Tests during which the machine stood still: they are tried again.

A virtual machine is stopped for a second or two now and then.  A bring-up in real time
then ends its motions, and its server refuses new ones for a moment, as they should.  A
test therefore begins after that moment.  Other failures are tried again only as often
as the option ``--reruns`` or a marker says.

What a failed test left behind does not reach the next try: the fixtures of its module
are set up anew, robots included.
"""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable
from typing import Final, final

import pytest
import pytest_rerunfailures

from tool0.protocol.freeze_meter import FROZEN, Activity, FreezeMeter
from tool0.server.outages import READING

LOOKS: Final = 0.1
"""[wall s]"""
FROZEN_HERE: Final = FROZEN - 2 * LOOKS
"""Another process looks at other moments, and may measure a longer standstill [s]."""
REFUSING: Final = READING + 2 * LOOKS
"""Time after a standstill in which a server may refuse motions [wall s]."""
TRIES: Final = 4
"""Of a test, as long as the machine stands still during each."""


@final
class _Watch:
    """Knows whether this process stood still since a test began."""

    def __init__(self) -> None:
        self._meter = FreezeMeter(Activity(frozen=FROZEN_HERE))
        self._lock = threading.Lock()
        self._frozen, self._began = -REFUSING, 0.0
        threading.Thread(target=self._keep_looking, daemon=True).start()

    def begin(self) -> None:
        """Wait until servers accept motions again, which no event announces."""
        self._look()
        while (left := self._frozen + REFUSING - time.monotonic()) > 0.0:
            time.sleep(left)
            self._look()
        self._began = time.monotonic()

    def has_frozen(self) -> bool:
        self._look()
        return self._frozen >= self._began

    def _look(self) -> None:
        with self._lock:
            if self._meter.look():
                self._frozen = time.monotonic()

    def _keep_looking(self) -> None:
        while True:
            time.sleep(LOOKS)
            self._look()


@final
class _Retries:
    def __init__(self, usual: int) -> None:
        self._usual = usual
        """Number of further tries without a standstill."""
        self._watch = _Watch()

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        if vars(item).get("execution_count", 1) > 1:
            _tear_down_to_session(item)
        self._watch.begin()

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        for item in items:
            if item.get_closest_marker("flaky") is None:
                again = self._condition(item)
                item.add_marker(pytest.mark.flaky(reruns=TRIES - 1, condition=again))

    def _condition(self, item: pytest.Item) -> Callable[[], bool]:
        def is_tried_again() -> bool:
            n_tries: int = vars(item)["execution_count"]
            return n_tries <= self._usual or self._watch.has_frozen()

        return is_tried_again


@pytest.hookimpl(trylast=True)
def pytest_configure(config: pytest.Config) -> None:
    if config.pluginmanager.hasplugin("rerunfailures"):
        retries = _Retries(config.getoption("reruns") or 0)
        config.pluginmanager.register(retries)
        _send_at_once(config)


def _tear_down_to_session(item: pytest.Item) -> None:
    """Finish all fixtures but those of the session, which ``rerunfailures`` keeps."""
    pytest_rerunfailures._restore_suspended_finalizers(item)
    item.session._setupstate.teardown_exact(item.session)


def _send_at_once(config: pytest.Config) -> None:
    """Spare each test of a worker process 40 ms.

    The plugin sends two short messages per test to the main process.  The kernel keeps
    the second one back until the first is acknowledged.
    """
    database = getattr(config, "failures_db", None)
    if isinstance(link := getattr(database, "sock", None), socket.socket):
        link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
