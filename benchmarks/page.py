"""Measures the panel's page in Chromium with software GL: start-up and drawing."""

from __future__ import annotations

import shutil
import statistics
from dataclasses import dataclass
from typing import Final

from playwright.sync_api import Browser, sync_playwright

import tool0
from tool0.panel.server import Panel

VISITS: Final = 5
WATCHED: Final = 5.0
"""Time in which drawn frames are counted [wall s]."""
_SIZE: Final = {"width": 1440, "height": 900}
_FLAGS: Final = (
    "--no-sandbox",  # for containers that run as root
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",  # the same as without a GPU
)
_CONTROLS: Final = "[data-testid=enable-toggle]:not([disabled])"
_SCENE: Final = "[data-testid=scene][data-ready=true]"
_COUNT: Final = """
    window.drawn = 0;
    let isNew = false;
    const draw = WebGL2RenderingContext.prototype.drawElements;
    WebGL2RenderingContext.prototype.drawElements = function (...all) {
        isNew = true;
        return draw.apply(this, all);
    };
    const count = () => {
        if (isNew) window.drawn += 1;
        isNew = false;
        requestAnimationFrame(count);
    };
    requestAnimationFrame(count);
"""
"""Script that counts the frames in which something is drawn."""
_WAIT: Final = """
    (selector) => new Promise((done) => {
        const look = () => {
            if (document.querySelector(selector)) done(performance.now());
            else setTimeout(look, 5);
        };
        look();
    })
"""


@dataclass(frozen=True)
class PageFigures:
    """Medians of several visits over the loopback interface."""

    controls: float
    """Time from the request until the controls can be used [s]."""
    scene: float
    """Time from the request until the 3D view is complete [s]."""
    rate: float
    """Frames per second in the simple mode while the arm moves [Hz]."""


def chromium() -> str | None:
    """Return the path of the installed browser; None if there is none."""
    names = ("chromium", "google-chrome", "chromium-browser")
    return next(filter(None, map(shutil.which, names)), None)


def page_figures() -> PageFigures:
    """Visit the panel of a bring-up whose arm moves."""
    executable = chromium()
    assert executable is not None
    with (
        tool0.bringup() as robot,
        Panel(robot) as panel,
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(
            executable_path=executable, args=list(_FLAGS)
        )
        _visit(browser, panel.url)  # the first visit includes the start of the browser
        visits = [_visit(browser, panel.url) for _ in range(VISITS)]
        rate = _drawn_per_second(browser, robot, panel.url)
        browser.close()
    controls, scene = (
        statistics.median(values) for values in zip(*visits, strict=True)
    )
    return PageFigures(controls=controls, scene=scene, rate=rate)


def _visit(browser: Browser, url: str) -> tuple[float, float]:
    """Return the times until the controls and the scene are ready [s]."""
    page = browser.new_context(viewport=_SIZE).new_page()
    page.goto(url, wait_until="commit")
    times = [float(page.evaluate(_WAIT, what)) for what in (_CONTROLS, _SCENE)]
    page.context.close()
    return times[0] / 1000.0, times[1] / 1000.0


def _drawn_per_second(browser: Browser, robot: tool0.Robot, url: str) -> float:
    page = browser.new_context(viewport=_SIZE).new_page()
    page.add_init_script(_COUNT)
    page.goto(f"{url}{'&' if '?' in url else '?'}quality=low")
    page.locator(_SCENE).wait_for()
    robot.move_joints({"shoulder_pan_joint": 3.0}, speed=0.1)
    page.wait_for_timeout(500.0)
    before = page.evaluate("[performance.now(), window.drawn]")
    page.wait_for_timeout(1000.0 * WATCHED)
    after = page.evaluate("[performance.now(), window.drawn]")
    page.context.close()
    return float(1000.0 * (after[1] - before[1]) / (after[0] - before[0]))


if __name__ == "__main__":
    print(page_figures())
