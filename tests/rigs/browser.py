"""A real browser with the panel's page, its console errors and its requests."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable
from typing import Final
from urllib.parse import urlsplit

from playwright.sync_api import Browser, ConsoleMessage, Locator, Playwright

import tool0

TIMEOUT: Final = 60.0
"""Longest wait for anything; software GL on a busy machine is slow [wall s]."""
_NAMES: Final = ("chromium", "google-chrome", "chromium-browser")
_FLAGS: Final = (
    "--no-sandbox",  # CI's containers run as root
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",  # as where there is no GPU
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--lang=en-US",
    "--disable-features="
    # of Chromium's own window, each of which starts a process per page
    "WebUIOmniboxPopup,WebUIOmniboxAimPopup,WebUIOmniboxFullPopup,"
    "SpareRendererForSitePerProcess,"
    # what Playwright disables, as this option replaces its list
    "AvoidUnnecessaryBeforeUnloadCheckSync,DestroyProfileOnBrowserClose,"
    "HttpsUpgrades,HttpsFirstBalancedModeAutoEnable,LensOverlay,MediaRouter,"
    "OptimizationHints,PaintHolding,PreconnectToSearch,ThirdPartyStoragePartitioning",
)


def find_chromium() -> str | None:
    """Return the Chromium that ``TOOL0_CHROMIUM`` names, or one that is on PATH."""
    chosen = os.environ.get("TOOL0_CHROMIUM")
    found = (shutil.which(name) for name in ((chosen,) if chosen else _NAMES))
    return next((path for path in found if path is not None), None)


def launch(playwright: Playwright, chromium: str) -> Browser:
    return playwright.chromium.launch(executable_path=chromium, args=list(_FLAGS))


def eventually(is_so: Callable[[], bool], what: str) -> None:
    """Wait for something in the robot that a page cannot announce."""
    deadline = time.monotonic() + TIMEOUT
    while not is_so():
        assert time.monotonic() < deadline, f"never: {what}"
        time.sleep(0.005)


def comes_to_rest(robot: tool0.Robot) -> None:
    """Wait until no joint moves; one just brought up sags a little first."""
    time_passes(robot, 0.5)
    eventually(
        lambda: all(abs(v) < 1e-4 for v in robot.joint_state.velocity.values()),
        "the robot rests",
    )


def time_passes(robot: tool0.Robot, duration: float) -> None:
    """Wait for `duration` [simulated s]."""
    until = robot.time + duration
    eventually(lambda: robot.time > until, f"{duration} s pass")


class Tab:
    """One visitor: a browser context of its own, with one page."""

    def __init__(
        self,
        browser: Browser,
        url: str = "",
        *,
        width: int = 1440,
        height: int = 900,
        has_touch: bool = False,
    ) -> None:
        self.context = browser.new_context(
            viewport={"width": width, "height": height},
            locale="en-US",
            has_touch=has_touch,
        )
        self.context.set_default_timeout(TIMEOUT * 1000)
        self.page = self.context.new_page()
        self.errors: list[str] = []
        """Errors on the console, with those of the content security policy."""
        self.expected: list[str] = []
        """Parts of those that a test causes on purpose."""
        self.requested: list[str] = []
        self.page.on("console", self._listen)
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("request", lambda request: self.requested.append(request.url))
        self.page.on("websocket", lambda socket: self.requested.append(socket.url))
        if url:
            self.open(url)

    def _listen(self, message: ConsoleMessage) -> None:
        if message.type == "error":
            self.errors.append(message.text)

    def open(self, url: str) -> None:
        """Open the panel at ``url`` and wait until it is connected."""
        self.page.goto(f"{url}{'&' if '?' in url else '?'}quality=low")
        self.see("[data-testid=connection][data-state=open]")

    def get(self, test_id: str) -> Locator:
        return self.page.get_by_test_id(test_id)

    def see(self, selector: str) -> Locator:
        """Wait until ``selector`` is there to be seen."""
        found = self.page.locator(selector)
        found.first.wait_for()
        return found

    def text(self, test_id: str, expected: str) -> None:
        """Wait until an element's text contains ``expected``."""
        self.get(test_id).filter(has_text=expected).wait_for()

    def drive(self) -> None:
        """Switch *Drive* on."""
        self.get("enable-toggle").click()
        self.see("[data-testid=joint-slider-elbow_joint]:not([disabled])")

    def confirm(self) -> None:
        """Answer yes to what the page asks."""
        self.get("confirmation-act").click()
        self.get("confirmation").wait_for(state="hidden")

    def send_joint(self, joint: str, position: float) -> None:
        """Type where a joint is to go, in the unit that the page shows."""
        field = self.get(f"joint-field-{joint}")
        field.fill(str(position))
        field.press("Enter")

    def shows_joint(self, joint: str, position: float, within: float) -> None:
        """Wait until the page shows the joint near ``position``, in its unit."""
        self.page.wait_for_function(
            """([id, wanted, within]) => {
                const shown = document.querySelector(`[data-testid="${id}"]`);
                return Math.abs(Number(shown?.textContent) - wanted) < within;
            }""",
            arg=[f"joint-actual-{joint}", position, within],
        )

    def foreign_requests(self) -> list[str]:
        """Return the addresses of other servers that the page requested."""
        host = urlsplit(self.page.url).netloc
        local = ("data", "blob")
        parts = [(url, urlsplit(url)) for url in self.requested]
        return [u for u, p in parts if p.scheme not in local and p.netloc != host]

    def close(self) -> None:
        """Close the page; fail if it logged an error or requested other servers.

        It logs one if its server ends first.  Closing twice is allowed.
        """
        foreign = self.foreign_requests()
        self.context.close()
        unexpected = [
            text
            for text in self.errors
            if not any(part in text for part in self.expected)
        ]
        assert not unexpected, unexpected
        assert not foreign, foreign
