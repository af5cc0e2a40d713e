"""Small robots that many tests share."""

from __future__ import annotations

import os
import signal
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, settings
from skew_robot import build_model

import tool0
from tool0.description.model import RobotModel
from tool0.installation.gazebo.installation import (
    NAMED_BY,
    find_system,
    from_prefix,
    private_prefix,
)

if TYPE_CHECKING:
    from tool0.panel.server import Panel


pytest_plugins = ["side_by_side", "standstill"]

# In a shell's background and under nohup, signals are ignored, also by all children.
# A handler is not inherited: children of a process that has one hear the signal.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
if signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, lambda number, frame: None)

settings.register_profile(  # a busy machine is slow, and no test fails for it
    "tests", deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("tests")

PRIVATE_GAZEBO = None if find_system() else from_prefix(private_prefix())
"""Of the person who runs the tests."""


@pytest.fixture(scope="session", autouse=True)
def runtime_folder() -> Iterator[Path]:
    """Keep bring-ups away from those of other processes, which may have their names.

    What is brought up for many tests knows nothing that the person saved, either.
    """
    with (  # below tmp_path, the path of a socket would be too long
        tempfile.TemporaryDirectory(prefix="tool0-") as folder,
        pytest.MonkeyPatch.context() as patch,
    ):
        patch.setenv("XDG_RUNTIME_DIR", folder)
        keep_data_in(Path(folder, "data"), patch)
        yield Path(folder)


@pytest.fixture(autouse=True)
def data_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Keep what a test saves away from what others have saved."""
    folder = tmp_path / "data"
    keep_data_in(folder, monkeypatch)
    return folder


def keep_data_in(folder: Path, patch: pytest.MonkeyPatch) -> None:
    """Let nothing be read from where the person who runs the tests has saved it.

    Their Gazebo is in the same place; a test finds it nevertheless.
    """
    if PRIVATE_GAZEBO is not None and NAMED_BY not in os.environ:
        patch.setenv(NAMED_BY, str(PRIVATE_GAZEBO.prefix))
    patch.setenv("XDG_DATA_HOME", str(folder))


@pytest.fixture
def skew_model() -> RobotModel:
    return build_model()


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    """Bring the usual robot up, in real time."""
    with tool0.bringup() as robot:
        yield robot


@pytest.fixture
def panel(robot: tool0.Robot) -> Iterator[Panel]:
    """Serve it."""
    from tool0.panel.server import Panel

    with Panel(robot) as panel:
        yield panel
