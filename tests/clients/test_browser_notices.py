"""What a page says when something goes wrong, and what needs another press."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from browser import comes_to_rest, eventually, time_passes
from test_browser_tool import opens_the_tool, position

import tool0
from conftest import OpenTab
from tool0.panel.server import Panel

CONTROLS = ("jog-z-minus", "jog-z-plus", "tool-go", "joint-slider-elbow_joint")


@pytest.fixture
def cell() -> Iterator[tool0.Robot]:
    with tool0.bringup(scene="table_and_cubes") as robot:
        yield robot


def test_no_banner_moves_a_control(
    panel: Panel, robot: tool0.Robot, open_tab: OpenTab
) -> None:
    """Otherwise another button would come to lie under the pointer."""
    tab = open_tab(panel.url)
    opens_the_tool(tab)
    tab.get("jog-z-minus").scroll_into_view_if_needed()
    comes_to_rest(robot)
    before = [tab.get(name).bounding_box() for name in CONTROLS]
    robot.arm.control_box.stop_protectively("a test")
    tab.get("protective-stop-banner").wait_for()
    assert [tab.get(name).bounding_box() for name in CONTROLS] == before
    robot.emergency_stop()
    tab.get("estop-banner").wait_for()
    tab.text("driving-state", "emergency stop")
    assert [tab.get(name).bounding_box() for name in CONTROLS] == before


def test_a_target_in_the_table_is_gone_to_only_anyway(
    open_tab: OpenTab, cell: tool0.Robot
) -> None:
    with Panel(cell) as panel:
        tab = open_tab(panel.url)
        opens_the_tool(tab)
        comes_to_rest(cell)
        start = position(cell)
        field = tab.get("tool-2")
        field.fill("-20")
        field.press("Enter")
        tab.get("tool-posture").wait_for()
        place = tab.get("tool-go").bounding_box()
        tab.get("tool-go").click()
        tab.text("plan-obstacle", "'table'")
        tab.text("plan-problem", "no posture of the target is free")
        assert tab.get("tool-go").bounding_box() == place
        time_passes(cell, 0.5)
        assert position(cell) == pytest.approx(start, abs=1e-3)
        tab.get("plan-anyway").click()
        eventually(lambda: position(cell)[2] < start[2] - 0.05, "it goes anyway")
        tab.get("plan").wait_for(state="detached")
        time_passes(cell, 3.0)  # it presses on the table
        tab.get("pose-go-home").click()
        tab.text("plan-problem", "the start is in collision")
        tab.get("plan-anyway").click()  # aborted, as the table holds the arm back
        time_passes(cell, 3.0)
        assert tab.get("enable-toggle").is_checked()  # nobody else moved the robot
        tab.get("pose-go-home").click()

        def comes_back() -> bool:
            if tab.get("plan-anyway").is_visible():  # it may still be in the table
                tab.get("plan-anyway").click()
            return position(cell)[2] > start[2] - 0.02

        eventually(comes_back, "it comes back")
        assert tab.get("enable-toggle").is_checked()
        tab.close()
