"""Small robots that many tests share."""

from __future__ import annotations

from pathlib import Path

import pytest
from skew_robot import build_model

from tool0.description.model import RobotModel


@pytest.fixture(autouse=True)
def data_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Keep what a test saves away from what the person who runs it has saved."""
    folder = tmp_path / "data"
    monkeypatch.setenv("XDG_DATA_HOME", str(folder))
    return folder


@pytest.fixture
def skew_model() -> RobotModel:
    return build_model()
