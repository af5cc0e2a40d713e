"""Film the panel while it is used for jogging, teaching and planning.

usage: python tools/film_panel.py {jog,teach,plan} docs/images/jog.webp

The film is an animated WebP in real time.  A dot shows the position of the pointer.
The tool needs Chromium (tools/setup-browser).  On a machine without a GPU, run no other
programs during the recording.
"""

from __future__ import annotations

import argparse
import base64
import io
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import av
from panel_page import panel_page
from playwright.sync_api import CDPSession, Locator, Page

import tool0
from tool0.panel.server import Panel
from tool0.scene import Box

WIDTH, HEIGHT = 1280, 800
SCALE = 0.625
"""Size of the film, as a fraction of the page's size."""
FRAME_RATE = 6  # [Hz]
ENCODER = {"quality": "45", "compression_level": "6"}
_POINTER = """() => {
    const dot = document.createElement("div");
    dot.style.cssText = "position:fixed;z-index:9999;width:18px;height:18px;" +
        "border-radius:50%;background:#e6450088;border:2px solid #e64500;" +
        "pointer-events:none;transform:translate(-50%,-50%);left:50%;top:50%";
    document.body.append(dot);
    window.addEventListener("pointermove", event => {
        dot.style.left = `${event.clientX}px`;
        dot.style.top = `${event.clientY}px`;
    }, true);
    window.addEventListener("pointerdown", () => {
        dot.style.background = "#e64500";
    }, true);
    window.addEventListener("pointerup", () => {
        dot.style.background = "#e6450088";
    }, true);
}"""


class Film:
    """The pictures of a page, each with its time."""

    def __init__(self, page: Page) -> None:
        self._session: CDPSession = page.context.new_cdp_session(page)
        self._session.on("Page.screencastFrame", self._keep)
        self.frames: list[tuple[float, bytes]] = []
        """Time [s] and JPEG data of each picture."""

    def start(self) -> None:
        settings = {"format": "jpeg", "quality": 90, "everyNthFrame": 1}
        self._session.send("Page.startScreencast", settings)

    def stop(self) -> None:
        self._session.remove_listener("Page.screencastFrame", self._keep)
        self._session.send("Page.stopScreencast")

    def _keep(self, event: dict[str, Any]) -> None:
        picture = base64.b64decode(event["data"])
        self.frames.append((event["metadata"]["timestamp"], picture))
        self._session.send("Page.screencastFrameAck", {"sessionId": event["sessionId"]})

    def write(self, path: Path) -> None:
        """Write the film at a constant rate.  It repeats endlessly."""
        width, height = round(WIDTH * SCALE), round(HEIGHT * SCALE)
        start, end = self.frames[0][0], self.frames[-1][0]
        with av.open(str(path), "w", format="webp", options={"loop": "0"}) as container:
            stream: Any = container.add_stream(
                "libwebp_anim", FRAME_RATE, options=ENCODER
            )
            stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
            index = 0
            for tick in range(math.floor((end - start) * FRAME_RATE) + 1):
                while (
                    index + 1 < len(self.frames)
                    and self.frames[index + 1][0] <= start + tick / FRAME_RATE
                ):
                    index += 1
                picture = _decoded(self.frames[index][1])
                small = picture.reformat(width, height, "yuv420p", interpolation="AREA")
                container.mux(stream.encode(small))
            container.mux(stream.encode(None))


def _decoded(jpeg: bytes) -> Any:
    with av.open(io.BytesIO(jpeg), format="mjpeg") as picture:
        return next(picture.decode(video=0))


class Person:
    """Uses the page like a person does: moves the pointer, holds, clicks and waits."""

    def __init__(self, page: Page, robot: tool0.Robot) -> None:
        self.page, self.robot = page, robot

    def get(self, test_id: str) -> Locator:
        return self.page.get_by_test_id(test_id)

    def waits(self, duration: float) -> None:
        self.page.wait_for_timeout(1000.0 * duration)

    def points(self, test_id: str) -> None:
        place = self.get(test_id)
        place.scroll_into_view_if_needed()
        box = place.bounding_box()
        assert box is not None
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        self.page.mouse.move(x, y, steps=12)
        self.waits(0.2)

    def clicks(self, test_id: str) -> None:
        self.points(test_id)
        self.get(test_id).click()
        self.waits(0.4)

    def holds(self, test_id: str, duration: float) -> None:
        self.points(test_id)
        self.page.mouse.down()
        self.waits(duration)
        self.page.mouse.up()
        self.waits(0.4)

    def types(self, test_id: str, text: str) -> None:
        self.points(test_id)
        self.get(test_id).fill(text)
        self.get(test_id).press("Enter")
        self.waits(0.5)


def jog(person: Person) -> None:
    """Move the tool with buttons, and then the gripper."""
    person.clicks("enable-toggle")
    person.clicks("tool-toggle")
    for button in ("jog-z-minus", "jog-y-plus", "jog-z-plus"):
        person.holds(button, 1.4)
    person.waits(0.6)


def teach(person: Person) -> None:
    """Add waypoints at the arm's current positions, and run the program."""
    person.clicks("enable-toggle")
    for lift in (-1.4, -1.75, -1.57):
        person.clicks("tab-motion")
        person.types("joint-field-shoulder_lift_joint", str(lift))
        person.waits(1.0)
        person.clicks("tab-program")
        person.clicks("program-add-move_joint")
    person.clicks("program-run")  # the arm is not at the start of the program
    person.points("program-approach")
    person.page.mouse.down()
    person.get("program-away").wait_for(state="hidden")
    person.page.mouse.up()
    person.clicks("program-run")
    person.get("program-state").filter(has_text="Done").wait_for()
    person.waits(1.0)


def plan(person: Person) -> None:
    """Move the tool to a position behind a wall.

    The page shows the planned path before the arm moves.
    """
    person.clicks("enable-toggle")
    person.clicks("tool-toggle")
    person.clicks("tool-frame-world")
    person.types("tool-1", "-350")
    person.get("tool-posture").wait_for()
    person.clicks("tool-go")
    person.page.locator("[data-testid=plan][data-state=found]").wait_for()
    person.waits(2.0)
    person.clicks("plan-move")
    person.get("tool-forget").wait_for(state="detached")
    person.waits(1.0)


def _cubes() -> tool0.Robot:
    return tool0.bringup(scene="table_and_cubes")


def _walled() -> tool0.Robot:
    robot = tool0.bringup(initial_pose="ready")
    wall = Box(size=(0.5, 0.04, 0.3))
    robot.scene.add("wall", wall, xyz=(0.55, -0.12, 0.05), rgba=(0.75, 0.6, 0.4, 1.0))
    return robot


FILMS: Final[dict[str, tuple[Callable[[], tool0.Robot], Callable[[Person], None]]]] = {
    "jog": (_cubes, jog),
    "teach": (_cubes, teach),
    "plan": (_walled, plan),
}


def main() -> None:
    """Make the film that the arguments specify."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("film", choices=FILMS)
    parser.add_argument("output", type=Path)
    parser.add_argument("--quality", choices=("low", "high"), default="low")
    options = parser.parse_args()
    bring_up, act = FILMS[options.film]
    with (
        bring_up() as robot,
        Panel(robot) as panel,
        panel_page(
            panel.url, width=WIDTH, height=HEIGHT, quality=options.quality
        ) as page,
    ):
        page.evaluate(_POINTER)
        film = Film(page)
        film.start()
        act(Person(page, robot))
        film.stop()
    film.write(options.output)


if __name__ == "__main__":
    main()
