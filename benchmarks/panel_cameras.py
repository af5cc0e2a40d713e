"""Measures the rate of live camera images at a page, and their cost.

The page is an HTTP client in a separate process.  Like the panel's page, the client
requests the next image when it has received an image.
"""

from __future__ import annotations

import http.client
import json
import logging
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final
from urllib.parse import urlsplit

import tool0
from tool0.panel.server import Panel, load

CAMERA: Final = "scene"
WIDTH: Final = 640
DURATION: Final = 5.0
"""Duration of one round [wall s]."""
ROUNDS: Final = 3
_MOVES: Final = {"shoulder_pan_joint": 3.0}


@dataclass(frozen=True)
class Rates:
    """Measured rates of images and of late ticks."""

    images: float
    """Images that the page receives per wall second."""
    capacity: float
    """Images that the machine renders per wall second without a page."""
    late_with: float
    """Number of ticks that began more than one control period late, per 10 s of
    simulated time."""
    late_without: float


def rates() -> Rates:
    """Measure the rates while the robot moves.

    For late ticks, the round with the fewest late ticks is used.
    """
    logging.getLogger("tool0.simulation.loop").setLevel(logging.ERROR)
    load()
    images: list[float] = []
    capacity: list[float] = []
    late_with: list[float] = []
    late_without: list[float] = []
    with tool0.bringup(scene="table_and_cubes") as robot, Panel(robot) as panel:
        robot.move_joints(_MOVES, duration=4.0 * ROUNDS * DURATION)
        _render(robot, 1.0)
        for _ in range(ROUNDS):
            capacity.append(_render(robot, DURATION))
            late_without.append(_late(robot, lambda: time.sleep(DURATION)))
            late_with.append(_late(robot, lambda: images.append(_page(panel.url))))
    return Rates(
        images=max(images),
        capacity=max(capacity),
        late_with=min(late_with),
        late_without=min(late_without),
    )


def _render(robot: tool0.Robot, duration: float) -> float:
    """Return the number of images per second that are rendered consecutively."""
    camera = robot.simulation.cameras[CAMERA]
    sized = replace(camera, width=WIDTH, height=WIDTH * camera.height // camera.width)
    start, n_images = time.perf_counter(), 0
    while time.perf_counter() - start < duration:
        robot.simulation.cameras.render(sized)
        n_images += 1
    return n_images / (time.perf_counter() - start)


def _late(robot: tool0.Robot, act: Callable[[], object]) -> float:
    overruns, start = robot.snapshot.overruns, robot.time
    act()
    return (robot.snapshot.overruns - overruns) * 10.0 / (robot.time - start)


def _page(url: str) -> float:
    """Return the images per second that a page in another process receives."""
    done = subprocess.run(
        [sys.executable, __file__, url], check=True, capture_output=True
    )
    found: float = json.loads(done.stdout)
    return found


# ---- the process of the page ---------------------------------------------------------


def _ask(url: str) -> float:
    parts = urlsplit(url)
    assert parts.hostname is not None
    connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=60.0)
    start, number, n_images = time.perf_counter(), "0", 0
    while time.perf_counter() - start < DURATION:
        query = f"width={WIDTH}&after={number}&{parts.query}"
        connection.request("GET", f"/cameras/{CAMERA}/color?{query}")
        response = connection.getresponse()
        response.read()
        if response.status == http.HTTPStatus.OK:
            number = response.headers["x-image-number"]
            n_images += 1
    return n_images / (time.perf_counter() - start)


if __name__ == "__main__":
    print(json.dumps(_ask(sys.argv[1])))
