"""Debian's Chromium with the panel of a real bringup.

``make test`` promises a browser (``TOOL0_REQUIRE=browser``): there its absence fails.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator

import pytest
from browser import Tab, find_chromium, launch
from playwright.sync_api import Browser, sync_playwright

from tool0.panel.server import Panel, is_page_built

OpenTab = Callable[..., Tab]


def _absent(what: str) -> None:
    if "browser" in os.environ.get("TOOL0_REQUIRE", "").split():
        pytest.fail(f"{what}, which this run promised")
    pytest.skip(f"{what}; `make test` sees to it")


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    chromium = find_chromium()
    if chromium is None:
        _absent("no Chromium is installed")
    if not is_page_built():
        _absent("the panel's page is not built")
    assert chromium is not None
    with sync_playwright() as playwright:
        started = launch(playwright, chromium)
        yield started
        started.close()


@pytest.fixture
def open_tab(browser: Browser) -> Iterator[OpenTab]:
    """Open pages; at the end none may have complained, or asked anything outside."""
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
