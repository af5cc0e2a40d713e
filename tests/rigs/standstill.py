"""Tests during which the machine stood still: they are tried once more.

A virtual machine is stopped for a second or two now and then.  A bring-up in real time
then ends its motions, as it should.  Where no other program runs, no other failure is
tried again.
"""

from __future__ import annotations

import threading
import time
from typing import Final, final

import pytest

from tool0.protocol.freeze_meter import FreezeMeter

LOOKS: Final = 0.1
"""[wall s]"""
ONE_PROCESS: Final = ("tests/unit/", "tests/conformance/")


@final
class _Watch:
    """Knows whether this process stood still since a test began."""

    def __init__(self) -> None:
        self._meter = FreezeMeter()
        self._lock = threading.Lock()
        self._frozen = self._began = 0.0
        threading.Thread(target=self._keep_looking, daemon=True).start()

    def begin(self) -> None:
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
    def __init__(self) -> None:
        self._watch = _Watch()

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self) -> None:
        self._watch.begin()

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        again = pytest.mark.flaky(reruns=1, condition=self._watch.has_frozen)
        for item in items:
            if item.nodeid.startswith(ONE_PROCESS):
                item.add_marker(again)


def pytest_configure(config: pytest.Config) -> None:
    if config.pluginmanager.hasplugin("rerunfailures"):
        config.pluginmanager.register(_Retries())
