"""Take a picture of the panel as a browser shows it.

usage: python tools/screenshot_panel.py docs/images/panel.webp [--width 1440] …

It brings the example's scene up, or a cell (``--robots``), moves the arms with the
plots open, and waits until the page has drawn it.  Needs Chromium
(tools/setup-browser).
"""

from __future__ import annotations

import argparse
import base64
import sys
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

import tool0
from tool0.description.cell_file import parse_robots
from tool0.panel.server import Panel

ROOT = Path(__file__).resolve().parent.parent
SCENE = "table_and_cubes"
_QUALITY = 88
_SLOW = 120_000
"""Longest wait for software GL at its best quality [ms]."""


def main() -> None:
    """Take the picture that the arguments describe."""
    sys.path.insert(0, str(ROOT / "tests/rigs"))
    from browser import find_chromium, launch  # noqa: PLC0415  # beside the tests

    options = _options()
    chromium = find_chromium()
    if chromium is None:
        sys.exit("there is no Chromium here; run tools/setup-browser")
    with (
        _robot(options.robots) as robot,
        Panel(robot) as panel,
        sync_playwright() as playwright,
    ):
        browser = launch(playwright, chromium)
        context = browser.new_context(
            viewport={"width": options.width, "height": options.height},
            color_scheme=options.theme,
            locale={"en": "en-US", "zh": "zh-CN"}[options.language],
        )
        context.set_default_timeout(_SLOW)
        page = context.new_page()
        page.goto(f"{panel.url}?quality={options.quality}")
        page.locator("[data-testid=scene][data-ready=true]").wait_for()
        if options.select:
            page.get_by_test_id(f"robot-{options.select}").click()
        if options.plots:
            page.get_by_test_id("plots-toggle").click()
            page.get_by_test_id("plots-chart").wait_for()
            page.get_by_test_id("plots-window-60").click()
        for goal in robot.go_to_pose("ready"):
            goal.wait(60.0)
        for gripper in robot.grippers.values():
            gripper.move(opening=0.6 * gripper.geometry.max_opening).wait(60.0)
        _wait_for_frames(page, 4)
        _wait_for_real_time(page)
        options.output.write_bytes(_picture(page))
        browser.close()


def _robot(robots: list[str] | None) -> tool0.Robot:
    if robots is None:
        return tool0.bringup(scene=SCENE)
    return tool0.bringup(cell=parse_robots(robots))


def _picture(page: Page) -> bytes:
    """Return a picture of the page as WebP, a sixth of the size of a PNG."""
    browser = page.context.new_cdp_session(page)
    settings = {"format": "webp", "quality": _QUALITY}
    return base64.b64decode(browser.send("Page.captureScreenshot", settings)["data"])


def _wait_for_frames(page: Page, count: int) -> None:
    """Wait until the scene was drawn some more times, or has nothing new to draw."""
    frames = "Number(document.querySelector('[data-testid=scene]').dataset.frames)"
    start = page.evaluate(frames)
    end = page.evaluate("performance.now()") + 10_000
    page.wait_for_function(
        f"([last, end]) => {frames} >= last || performance.now() > end",
        arg=[start + count, end],
    )


def _wait_for_real_time(page: Page) -> None:
    """Wait until drawing no longer slows the simulation down, on most machines."""
    factor = "parseFloat(document.querySelector('[data-testid=sim-rtf]').textContent)"
    end = page.evaluate("performance.now()") + 30_000
    page.wait_for_function(
        f"end => {factor} >= 0.99 || performance.now() > end", arg=end
    )


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("output", type=Path)
    parser.add_argument("--width", type=int, default=1440)
    parser.add_argument("--height", type=int, default=900)
    parser.add_argument("--theme", choices=("light", "dark"), default="light")
    parser.add_argument("--language", choices=("en", "zh"), default="en")
    parser.add_argument("--quality", choices=("low", "high"), default="high")
    parser.add_argument("--plots", action=argparse.BooleanOptionalAction, default=True)
    parser.add_argument("--robots", nargs="+", metavar="NAME=ARM+GRIPPER@X,Y,Z")
    parser.add_argument("--select", help="the robot to select, of several")
    return parser.parse_args()


if __name__ == "__main__":
    main()
