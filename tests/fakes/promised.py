"""What a machine may lack, and a run of the tests may promise: ``TOOL0_REQUIRE``."""

from __future__ import annotations

import os
from typing import NoReturn

import pytest

from tool0.engines.gazebo.readiness import readiness


def absent(part: str, why: str) -> NoReturn:
    """Skip visibly, or fail if this run promised ``part``: browser, gazebo, ros1."""
    if part in os.environ.get("TOOL0_REQUIRE", "").split():
        pytest.fail(f"{why}, which this run promised")
    pytest.skip(f"{why}; `make test` sees to it")


def require_engine(name: str) -> None:
    """Skip visibly, or fail if this run promised it, if there is no Gazebo for it."""
    if name == "gazebo" and not (found := readiness()).can_run:
        absent(name, f"no Gazebo can run here ({'; '.join(found.missing)})")
