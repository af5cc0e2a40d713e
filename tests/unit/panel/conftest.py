from collections.abc import Iterator

import pytest

import tool0
from tool0.panel.server import Panel


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup() as robot:
        yield robot


@pytest.fixture
def panel(robot: tool0.Robot) -> Iterator[Panel]:
    with Panel(robot) as panel:
        yield panel
