"""Debian's Chromium with the panel of a real bringup.

``make test`` promises a browser (``TOOL0_REQUIRE=browser``): there its absence fails.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from browser import Tab, comes_to_rest, find_chromium, launch
from playwright.sync_api import Browser, sync_playwright
from promised import absent

import tool0
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose
from tool0.panel.server import Panel, is_page_built

OpenTab = Callable[..., Tab]


@pytest.fixture(scope="package")
def browser() -> Iterator[Browser]:
    """Start one for all pages of these tests, each in a context of its own."""
    chromium = find_chromium()
    if chromium is None:
        absent("browser", "no Chromium is installed")
    if not is_page_built():
        absent("browser", "the panel's page is not built")
    with sync_playwright() as playwright:
        started = launch(playwright, chromium)
        yield started
        started.close()


@pytest.fixture(scope="module")
def shared_panel() -> Iterator[Panel]:
    """Serve a robot that no test changes."""
    with tool0.bringup() as robot, Panel(robot) as panel:
        yield panel


@pytest.fixture
def open_tab(browser: Browser) -> Iterator[OpenTab]:
    """Open pages; none may log an error or request another server."""
    tabs: list[Tab] = []

    def open_(url: str = "") -> Tab:
        tabs.append(Tab(browser))
        if url:
            tabs[-1].open(url)
        return tabs[-1]

    yield open_
    for tab in tabs:
        tab.close()


@pytest.fixture
def tab(panel: Panel, open_tab: OpenTab) -> Tab:  # the server outlives its pages
    return open_tab(panel.url)


WALL = SceneObject(
    name="wall",
    geometry=Box(size=(0.5, 0.04, 0.45)),
    pose=Pose(xyz=(0.55, -0.12, 0.225)),
    mass=None,
)


@pytest.fixture
def walled(robot: tool0.Robot) -> tool0.Robot:
    """Return a robot with a wall beside its tool."""
    for goal in robot.go_to_pose("ready"):
        goal.wait(60.0)
    robot.scene.add(WALL)
    comes_to_rest(robot)
    return robot
