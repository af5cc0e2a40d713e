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
    "tests/test_examples.py",
    "tests/documentation/test_python_blocks.py",
    "tests/documentation/test_shell_blocks.py",
    "tests/documentation/test_tutorials.py",
)
"""Here nothing that is costly is shared by the tests of a file: each goes anywhere."""
BY_ENGINE: Final = "tests/conformance/"
"""Here the tests of a file with one engine share a robot."""


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
        file, _, test = nodeid.partition("::")
        if file in SINGLE:
            return nodeid
        is_in_gazebo = file.startswith(BY_ENGINE) and "[gazebo" in test
        return f"{file}, gazebo" if is_in_gazebo else file
