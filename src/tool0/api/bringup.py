"""``tool0.bringup``: a robot in this process."""

from __future__ import annotations

from typing import Any

from tool0.api.channel import LocalChannel
from tool0.api.robot import Robot
from tool0.runtime.bringup import start_simulation


def bringup(**keywords: Any) -> Robot:
    """Bring a robot up: description, physics, drives, controllers."""
    return Robot(LocalChannel(start_simulation(**keywords)))
