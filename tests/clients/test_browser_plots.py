"""Plots in a browser: values of the robot, cursors, zoom, and a layout that stays."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence

import pytest
from browser import Tab, comes_to_rest, eventually
from playwright.sync_api import Locator

import tool0

CHART = "plots-chart"
FORCES = ("fx", "fy", "fz", "tx", "ty", "tz")


def number(text: str | None) -> float:
    """Return the number that a text with a unit begins with."""
    found = re.match(r"-?\d+(\.\d+)?", text or "")
    assert found, f"no number in {text!r}"
    return float(found[0])


def open_plots(tab: Tab) -> None:
    tab.get("plots-toggle").click()
    tab.see(f"[data-testid={CHART}] canvas")


def pick(tab: Tab, pane: int, search: str, *test_ids: str) -> None:
    """Search signals in a pane, and tick some of what is found."""
    tab.get(f"plots-pick-{pane}").click()
    tab.get("plots-search").fill(search)
    for test_id in test_ids:
        tab.get(test_id).check()
    tab.get(f"plots-pick-{pane}").click()


def shown(tab: Tab, signal: str, cursor: str = "now") -> Locator:
    return tab.page.locator(f'[data-signal="{signal}"][data-cursor="{cursor}"]')


def table(tab: Tab) -> tuple[list[str], list[list[float]]]:
    """Return the header and the rows of the CSV file that the page saves."""
    with tab.page.expect_download() as download:
        tab.get("plots-csv").click()
    with download.value.path().open(encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return header, [[float(cell or "nan") for cell in row] for row in rows]


def click_chart(tab: Tab, part: float) -> None:
    """Click the drawing area at a part of its width."""
    box = tab.see(f"[data-testid={CHART}] .u-over").first.bounding_box()
    assert box is not None
    x, y = box["x"] + part * box["width"], box["y"] + 0.5 * box["height"]
    tab.page.mouse.click(x, y)


def visible(tab: Tab) -> tuple[float, float]:
    """Return the range of time that the first pane shows [s]."""
    # in one step: dragging moves both ends
    start, end = tab.get(CHART).evaluate(
        "chart => [chart.dataset.from, chart.dataset.to]"
    )
    return number(start), number(end)


def width_of(span: tuple[float, float]) -> float:
    return span[1] - span[0]


def becomes(output: Locator, value: float, within: float) -> None:
    """Wait until a reading is near ``value``, in the unit of the page."""

    def is_near() -> bool:
        text = output.text_content() or ""
        is_known = re.match(r"-?\d", text) is not None
        return is_known and abs(number(text) - value) <= within

    eventually(is_near, f"{output} shows {value:.3f}")


def nearest(rows: Sequence[Sequence[float]], time: float) -> Sequence[float]:
    return min(rows, key=lambda row: abs(row[0] - time))


def test_a_plotted_wrench_is_that_of_the_robot(robot: tool0.Robot, tab: Tab) -> None:
    open_plots(tab)
    pick(tab, 0, "wrench", "plots-all-wrench")
    robot.apply_wrench("tool0", force=(3.0, -7.0, -20.0))
    comes_to_rest(robot)
    robot.pause()
    wrench = robot.arm.motion.state.wrench
    assert max(map(abs, wrench[:3])) > 15.0
    for axis, value in zip(FORCES, wrench, strict=True):
        # the newest frame may be on its way when the simulation is paused
        becomes(shown(tab, f"wrench/arm/{axis}"), value, within=0.011)
    header, rows = table(tab)
    assert header[0] == "time [s]"
    columns = [header.index(f"arm.{axis} [{unit_of(axis)}]") for axis in FORCES]
    assert rows[-1][0] == pytest.approx(robot.time, abs=1e-6)
    last = [rows[-1][column] for column in columns]
    assert last == pytest.approx(list(wrench), abs=1e-3)


def unit_of(axis: str) -> str:
    return "N*m" if axis.startswith("t") else "N"


def test_cursors_show_the_values_that_the_plot_has(
    robot: tool0.Robot, tab: Tab
) -> None:
    open_plots(tab)
    pick(tab, 0, "elbow position", "plots-signal-joint/elbow_joint/position")
    for goal in robot.move_joints({"elbow_joint": 1.0}, speed=1.0):
        goal.wait()
    tab.get("plots-pause").click()
    tab.see("[data-testid=plots-pause][aria-pressed=true]")
    click_chart(tab, 0.3)
    click_chart(tab, 0.95)
    signal = "joint/elbow_joint/position"
    shown(tab, signal, "difference").filter(has_text="rad").wait_for()
    times = tab.page.locator(".plots-times td").all_text_contents()[:3]
    a, b, difference = map(number, times)
    assert difference == pytest.approx(b - a, abs=0.002)
    header, rows = table(tab)
    column = header.index("elbow_joint.position [rad]")
    for cursor, time in (("a", a), ("b", b)):
        value = number(shown(tab, signal, cursor).text_content())
        # the page rounds the time: between two samples, either may be the nearer one
        samples = [nearest(rows, time + off)[column] for off in (-5e-4, 5e-4)]
        assert min(abs(value - sample) for sample in samples) <= 6e-4
    value = number(shown(tab, signal, "difference").text_content())
    values = [number(shown(tab, signal, one).text_content()) for one in "ab"]
    assert value == pytest.approx(values[1] - values[0], abs=2e-3)


def test_zoom_holds_a_range_and_the_layout_stays(robot: tool0.Robot, tab: Tab) -> None:
    open_plots(tab)
    tab.get("plots-window-5").click()
    tab.get("plots-add-pane").click()
    pick(tab, 1, "tool", "plots-all-tool")
    pick(tab, 1, "factor", "plots-signal-simulation/real_time_factor")
    tab.see("[data-testid=plots-chart-1] canvas")
    box = tab.see(f"[data-testid={CHART}] .u-over").first.bounding_box()
    assert box is not None
    tab.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    tab.page.mouse.wheel(0, -400)
    tab.see("[data-testid=plots-pause][aria-pressed=true]")
    eventually(lambda: width_of(visible(tab)) < 4.0, "the wheel zooms")
    zoomed = visible(tab)
    tab.page.mouse.down()
    tab.page.mouse.move(box["x"] + 0.9 * box["width"], box["y"] + 10, steps=4)
    tab.page.mouse.up()
    eventually(lambda: visible(tab)[1] < zoomed[1] - 0.5, "dragging pans")
    assert width_of(visible(tab)) == pytest.approx(width_of(zoomed), abs=0.01)
    _, rows = table(tab)
    assert all(visible(tab)[0] <= row[0] <= visible(tab)[1] for row in rows)
    tab.get("plots-pause").click()
    tab.see("[data-testid=plots-pause][aria-pressed=false]")
    tab.page.reload()
    tab.see("[data-testid=plots-chart-1] canvas")
    assert tab.get("plots-window-5").get_attribute("aria-checked") == "true"
    factor = shown(tab, "simulation/real_time_factor")
    factor.filter(has_text=re.compile(r"\d")).wait_for()
    for axis, value in zip("xyz", robot.pose("tool0").position, strict=True):
        becomes(shown(tab, f"tool/arm/{axis}"), 1000.0 * value, within=0.3)
