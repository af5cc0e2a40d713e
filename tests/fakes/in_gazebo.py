"""What the tests on real gzserver share."""

from __future__ import annotations

from typing import Protocol

import tool0
from tool0.engines.gazebo.engine import GazeboEngine

PATIENCE = 30.0
"""For what takes a moment on a busy machine [wall s]."""


class BringUp(Protocol):
    """Bring a robot up in Gazebo, as ``tool0.bringup`` does."""

    def __call__(self, **options: object) -> tuple[tool0.Robot, GazeboEngine]: ...
