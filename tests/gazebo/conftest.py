"""Real gzserver.  Where there is none, the tests say so (see ``promised.py``)."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from flat_options import configured
from in_gazebo import BringUp
from promised import absent

import tool0
from tool0.engines.gazebo.engine import GazeboEngine
from tool0.installation.gazebo.installation import GazeboInstallation, find_installation
from tool0.installation.gazebo.status import gazebo_status


@pytest.fixture(scope="session", autouse=True)
def gazebo() -> GazeboInstallation:
    """Name the Gazebo under test."""
    found = gazebo_status()
    if not found.can_run:
        absent("gazebo", f"no Gazebo can run here ({'; '.join(found.missing)})")
    return find_installation()


@pytest.fixture
def bring_up() -> Iterator[BringUp]:
    """Bring robots up, as fast as possible unless told otherwise, and close them."""
    robots = []

    def bring_one_up(**options: object) -> tuple[tool0.Robot, GazeboEngine]:
        robot = tool0.bringup(
            **configured(**{"engine": "gazebo", "realtime": False, **options})
        )
        robots.append(robot)
        assert isinstance(robot.engine, GazeboEngine)
        return robot, robot.engine

    yield bring_one_up
    for robot in robots:
        robot.close()
