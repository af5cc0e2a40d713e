"""Small robots that many tests share."""

from __future__ import annotations

import pytest
from skew_robot import build_model

from tool0.description.model import RobotModel


@pytest.fixture
def skew_model() -> RobotModel:
    return build_model()
