"""One suite for every engine: what a person may rely on, whatever steps the physics."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from conformance_types import BringUp
from flat_options import configured
from promised import absent

import tool0
from tool0.engines.registry import engine_names
from tool0.errors import EngineUnavailableError


@pytest.fixture(scope="session", params=engine_names())
def engine(request: pytest.FixtureRequest) -> str:
    """Name an engine, or skip visibly where it is not installed (see ``promised``)."""
    name: str = request.param
    try:
        tool0.bringup(engine=name, gripper=None, realtime=False).close()
    except (EngineUnavailableError, ImportError) as error:
        absent(name, f"engine '{name}' is absent: {error}")
    return name


@pytest.fixture(scope="module")
def shared_robot(engine: str) -> Iterator[tool0.Robot]:
    """Bring the usual robot up, for several tests of a module."""
    simulation = tool0.SimulationConfig(engine=engine)
    with tool0.bringup(simulation=simulation, realtime=False) as robot:
        yield robot


@pytest.fixture
def robot(shared_robot: tool0.Robot) -> tool0.Robot:
    """Return the usual robot as if just brought up.

    A test that leaves behind more than a reset undoes has to bring up its own.
    """
    shared_robot.reset()
    return shared_robot


@pytest.fixture
def bring_up(engine: str) -> Iterator[BringUp]:
    """Bring robots up on the engine, as fast as possible, and close them."""
    robots = []

    def bring_one_up(**options: object) -> tool0.Robot:
        robot = tool0.bringup(
            **configured(**{"engine": engine, "realtime": False, **options})
        )
        robots.append(robot)
        return robot

    yield bring_one_up
    for robot in robots:
        robot.close()
