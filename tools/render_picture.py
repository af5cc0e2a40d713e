"""Render the picture of the README: python tools/render_picture.py OUTPUT.webp [POSE].

The picture is rendered with the robot's own camera.  See docs/how-to/cameras.md for the
requirements.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

from webp import encode_webp

import tool0
from tool0.description.camera import Camera, looking

CAMERA = Camera(
    name="readme",
    pose=looking((1.11, -0.68, 0.51), (0.30, 0.0, 0.20)),
    width=1280,
    height=800,
    field_of_view=math.radians(45.0),
    far=20.0,
)


def render(pose: str) -> bytes:
    """Return a picture of the default robot in ``pose``, as WebP."""
    simulation = tool0.SimulationConfig(cameras=(CAMERA,), realtime=False)
    with tool0.bringup(initial_pose=pose, simulation=simulation) as robot:
        return encode_webp(robot.camera(CAMERA.name).image().rgb)


if __name__ == "__main__":
    Path(sys.argv[1]).write_bytes(render(sys.argv[2] if len(sys.argv) > 2 else "home"))
