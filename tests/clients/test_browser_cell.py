"""The panel of a cell: its controls move the selected robot, its E-stop stops all."""

from collections.abc import Iterator

import pytest
from browser import Tab, comes_to_rest, eventually
from playwright.sync_api import Browser

import tool0
from tool0.description.cell_file import parse_robots
from tool0.panel.server import Panel

CELL = ("left=ur5e+2f85@0,0.4,0", "right=ur10e+hande@0,-0.4,0")
ELBOWS = ("left_elbow_joint", "right_elbow_joint")
STOPPED = "[data-testid=estop][data-engaged=true]"


@pytest.fixture
def cell() -> Iterator[tool0.Robot]:
    with tool0.bringup(cell=parse_robots(CELL)) as robot:
        yield robot


def positions(cell: tool0.Robot, side: str) -> dict[str, float]:
    state = cell.joint_state.position
    return {name: at for name, at in state.items() if name.startswith(f"{side}_")}


def largest_change(before: dict[str, float], now: dict[str, float]) -> float:
    return max(abs(now[name] - before[name]) for name in before)


def link_at(tab: Tab, x: float, y: float) -> str:
    """Return what the 3D view says of a point of the window [px]."""
    tab.page.mouse.move(x, y)
    tip = """() => new Promise((done) => requestAnimationFrame(() =>
        requestAnimationFrame(() => {
            const tip = document.querySelector(".scene-tip");
            done(tip.hidden ? "" : tip.textContent);
        })))"""
    return str(tab.page.evaluate(tip))


def test_a_click_on_a_robot_selects_it(browser: Browser, cell: tool0.Robot) -> None:
    with Panel(cell) as panel:
        tab = Tab(browser, panel.url, width=500, height=500)
        tab.see("[data-testid=scene][data-ready=true]")
        box = tab.get("scene").bounding_box()
        assert box is not None
        grid = (
            (box["x"] + i * box["width"] / 14, box["y"] + j * box["height"] / 14)
            for j in range(3, 12)
            for i in range(3, 12)
        )
        at = next(point for point in grid if "right_" in link_at(tab, *point))
        tab.page.mouse.click(*at)
        tab.see("[data-testid=robot-right][aria-checked=true]")
        tab.close()


def test_the_controls_move_the_selected_robot_and_the_stop_brakes_both(
    browser: Browser, cell: tool0.Robot
) -> None:
    comes_to_rest(cell)
    with Panel(cell) as panel:
        tab = Tab(browser, panel.url, width=390, height=844)
        tab.see("[data-testid=robot-left][aria-checked=true]")
        assert tab.page.evaluate("document.documentElement.scrollWidth") <= 390
        tab.get("robot-left").press("ArrowRight")
        tab.see("[data-testid=robot-right][aria-checked=true]")
        assert tab.get("joint-slider-left_elbow_joint").count() == 0

        left, right = positions(cell, "left"), positions(cell, "right")
        tab.get("enable-toggle").click()
        tab.see("[data-testid=joint-slider-right_elbow_joint]:not([disabled])")
        slider = tab.get("joint-slider-right_elbow_joint")
        slider.press("Shift+ArrowRight")
        goal = float(slider.input_value())
        eventually(
            lambda: abs(positions(cell, "right")["right_elbow_joint"] - goal) < 0.03,
            "the right elbow is there",
        )
        assert goal > right["right_elbow_joint"] + 0.05

        tab.get("gripper-close").click()
        eventually(
            lambda: cell.grippers["right"].opening < 0.01, "the right gripper closes"
        )
        assert cell.grippers["left"].opening > 0.08
        assert largest_change(left, positions(cell, "left")) < 1e-3

        cell.move_joints(dict.fromkeys(ELBOWS, 0.5), speed=0.1)
        for name in ELBOWS:
            eventually(
                lambda name=name: abs(cell.joint_state.velocity[name]) > 0.1,
                f"{name} moves",
            )
        tab.get("estop").click()
        tab.see(STOPPED)
        comes_to_rest(cell)
        for name in ELBOWS:
            assert cell.joint_state.position[name] > 0.55
        assert tab.get("enable-toggle").is_disabled()
        tab.close()
