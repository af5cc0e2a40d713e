"""Tests in several processes at once (``pytest -n 2``): who goes with whom.

Those that measure wall time would disturb each other: ``make test`` runs them one at a
time.  Those of one file share a browser, a Gazebo or a ROS, and stay together.
"""

from __future__ import annotations

from typing import Final, final

import pytest
from xdist.remote import Producer
from xdist.scheduler import LoadScopeScheduling

SINGLE: Final = (
    "tests/conformance/",
    "tests/test_examples.py",
    "tests/test_tutorial.py",
)
"""Here little that is costly is shared by the tests of a file: each goes anywhere."""


def pytest_configure(config: pytest.Config) -> None:
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
