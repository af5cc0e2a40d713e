"""The panel's page in a browser, for the pictures of the documentation."""

from __future__ import annotations

import base64
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

_RIGS = Path(__file__).resolve().parent.parent / "tests/rigs"
_QUALITY = 88
_SLOW = 120_000
"""Longest wait for software GL at the best quality [ms]."""


@contextmanager
def panel_page(
    url: str,
    *,
    width: int = 1440,
    height: int = 900,
    theme: str = "light",
    language: str = "en",
    quality: str = "high",
) -> Iterator[Page]:
    """Open the panel at ``url``, and wait until its scene is drawn.

    Args:
        url: Address of the panel, in the form in which the panel prints it.
        width: Width of the window [px].
        height: Height of the window [px].
        theme: Color theme, ``light`` or ``dark``.
        language: Language of the page, ``en`` or ``zh``.
        quality: Quality of the drawing, ``low`` or ``high``.
    """
    sys.path.insert(0, str(_RIGS))
    from browser import find_chromium, launch  # noqa: PLC0415  # beside the tests

    chromium = find_chromium()
    if chromium is None:
        sys.exit("there is no Chromium here; run tools/setup-browser")
    with sync_playwright() as playwright:
        browser = launch(playwright, chromium)
        context = browser.new_context(
            viewport={"width": width, "height": height},
            color_scheme="dark" if theme == "dark" else "light",
            locale={"en": "en-US", "zh": "zh-CN"}[language],
        )
        context.set_default_timeout(_SLOW)
        page = context.new_page()
        page.goto(f"{url}?quality={quality}")
        page.locator("[data-testid=scene][data-ready=true]").wait_for()
        yield page
        browser.close()


def picture(page: Page) -> bytes:
    """Return a picture of the page as WebP, with a sixth of the size of a PNG."""
    browser = page.context.new_cdp_session(page)
    settings = {"format": "webp", "quality": _QUALITY}
    return base64.b64decode(browser.send("Page.captureScreenshot", settings)["data"])


def wait_for_frames(page: Page, count: int) -> None:
    """Wait until the scene has been drawn ``count`` more times.

    The wait also ends after 10 s, because there may be nothing new to draw.
    """
    frames = "Number(document.querySelector('[data-testid=scene]').dataset.frames)"
    start = page.evaluate(frames)
    end = page.evaluate("performance.now()") + 10_000
    page.wait_for_function(
        f"([last, end]) => {frames} >= last || performance.now() > end",
        arg=[start + count, end],
    )


def wait_for_real_time(page: Page) -> None:
    """Wait until the simulation runs in real time, or for at most 30 s.

    On most machines, drawing slows down the simulation at first.
    """
    factor = "parseFloat(document.querySelector('[data-testid=sim-rtf]').textContent)"
    end = page.evaluate("performance.now()") + 30_000
    page.wait_for_function(
        f"end => {factor} >= 0.99 || performance.now() > end", arg=end
    )
