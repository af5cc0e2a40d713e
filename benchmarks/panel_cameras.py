"""Live images of a camera: how many a page gets, and what they cost the control loop.

The page is an HTTP client in a process of its own, which asks for the next image when
it has one, as the panel's page does.
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
"""Of one round [wall s]."""
ROUNDS: Final = 3
_MOVES: Final = {"shoulder_pan_joint": 3.0}


@dataclass(frozen=True)
class Rates:
    """What was measured."""

    images: float
    """That the page gets per wall second."""
    capacity: float
    """Images that the machine renders per wall second, without a page."""
    late_with: float
    """Ticks that began more than a control period late, per 10 s of simulated time."""
    late_without: float


def rates() -> Rates:
    """Measure beside a moving robot; of the late ticks the quietest round counts."""
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
    """Return how many images a second are rendered one after the other."""
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
    """Return the images per second that a page in another process gets."""
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
