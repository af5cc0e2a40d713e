"""Render docs/images/plan.webp: python tools/render_plan.py OUTPUT.webp.

The picture shows an arm that carries a cube from a shelf over a wall.  Several poses on
one planned motion are drawn over each other.  The picture is rendered with the robot's
own camera.  See docs/how-to/cameras.md for the requirements.
"""

from __future__ import annotations

import math
import sys
from typing import Any

import av
import numpy as np
from numpy.typing import NDArray

import tool0
from tool0.api.grasps import find_bin
from tool0.cli.demos.hand import PickOptions
from tool0.cli.demos.shelf import pick_from_shelf
from tool0.description.camera import Camera, looking
from tool0.protocol.state import Snapshot

CAMERA = Camera(
    name="docs",
    pose=looking((1.75, -1.15, 1.0), (0.32, 0.12, 0.20)),
    width=1920,
    height=1280,
    field_of_view=math.radians(36.0),
    far=20.0,
)
WIDTH, HEIGHT = 960, 640
POSES = 5
"""Number of poses that are drawn along the path."""
OTHERS = 14
"""Number of pictures of the whole task from which the background is computed."""
FAINT, SOLID = 0.35, 0.8
"""Opacity of the intermediate poses, and of the first and last pose."""
MOVED = 12
"""Difference of color above which a pixel shows a moving part."""

Image = NDArray[np.uint8]


def pictures() -> tuple[list[Image], Image]:
    """Return pictures of the path at equal time intervals, and the background."""
    simulation = tool0.SimulationConfig(
        scene="shelf", cameras=(CAMERA,), realtime=False
    )
    seen: list[Snapshot] = []
    with tool0.bringup(simulation=simulation) as robot:
        into = find_bin(robot.scene.objects, "bin")
        report = pick_from_shelf(robot, "cube", into, PickOptions(), seen.append)
        if not report.success:
            sys.exit(f"the pick failed {report.failure}")
        before = list(report.phases)[: list(report.phases).index("carrying")]
        begun = seen[0].time + sum(report.phases[phase] for phase in before)
        view = robot.camera(CAMERA.name)

        def at(times: NDArray[np.float64]) -> list[Image]:
            chosen = [min(seen, key=lambda one: abs(one.time - time)) for time in times]
            return [view.image(snapshot).rgb for snapshot in chosen]

        way = at(begun + np.linspace(0.0, report.phases["carrying"], POSES))
        others = at(np.linspace(seen[0].time, seen[-1].time, OTHERS))
        behind = np.median([*way, *others], axis=0)
        return way, np.asarray(behind.round(), np.uint8)


def over_each_other(way: list[Image], behind: Image) -> Image:
    """Return one picture in which moving parts are drawn over the background."""
    drawn = behind.astype(np.float64)
    for number, picture in enumerate(way):
        is_end = number in {0, len(way) - 1}
        opacity = SOLID if is_end else FAINT
        moved = np.abs(picture.astype(np.int16) - behind).max(axis=2) > MOVED
        drawn[moved] += opacity * (picture[moved] - drawn[moved])
    return np.asarray(drawn.round(), np.uint8)


def write(path: str, picture: Image) -> None:
    """Write a WebP of half the size, for smooth edges."""
    with av.open(path, "w", format="webp") as container:
        stream: Any = container.add_stream("libwebp", 1, options={"quality": "80"})
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
        small = frame.reformat(WIDTH, HEIGHT, "yuv420p", interpolation="AREA")
        container.mux(stream.encode(small))
        container.mux(stream.encode(None))


if __name__ == "__main__":
    write(sys.argv[1], over_each_other(*pictures()))
