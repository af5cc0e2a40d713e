"""Tests in several processes at once: who goes with whom, and what runs alone.

Most tests wait more than they compute, so two processes (``pytest -n 2``) take little
more than half of the time.  Those that measure wall time would measure each other: they
are marked ``alone``, and run when no other process runs a test.
"""

from __future__ import annotations

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final, final

import pytest
from xdist.remote import Producer
from xdist.scheduler import LoadScopeScheduling

SINGLE: Final = ("tests/conformance/", "tests/gazebo/")
"""Here nothing that is costly is shared by the tests of a file: each goes anywhere."""
_TURNSTILE: Final = Path(__file__)
_FLOOR: Final = Path(__file__).with_name("processes.py")
"""What is locked, never changed: every process has these two files."""


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line(
        "markers", "alone: it measures wall time; nothing beside it"
    )
    config.addinivalue_line(
        "markers", "slow: it starts programs or tries much; `make check` leaves it out"
    )


@pytest.hookimpl(optionalhook=True)  # not without the plugin pytest-xdist
def pytest_xdist_make_scheduler(
    config: pytest.Config, log: Producer
) -> LoadScopeScheduling:
    return _ByFile(config, log)


@final
class _ByFile(LoadScopeScheduling):
    """The largest files first and whole, at last what fills the gaps at the end."""

    def _split_scope(self, nodeid: str) -> str:
        return nodeid if nodeid.startswith(SINGLE) else nodeid.partition("::")[0]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[object]:
    if not hasattr(item.config, "workerinput"):
        return (yield)
    alone = item.get_closest_marker("alone") is not None
    with _locked(_FLOOR, alone):
        return (yield)


@contextmanager
def _locked(path: Path, exclusively: bool) -> Iterator[None]:
    """Share the floor with others, or have it alone; who came first goes first."""
    with path.open() as floor:
        with _TURNSTILE.open() as turnstile:
            fcntl.flock(turnstile, fcntl.LOCK_EX)
            fcntl.flock(floor, fcntl.LOCK_EX if exclusively else fcntl.LOCK_SH)
        yield
