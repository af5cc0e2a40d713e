"""Render the README's pictures of a pick: python tools/render_pick.py OUTPUT.png."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

import tool0
from tool0.cli.pick_demo.grasps import find_bin
from tool0.cli.pick_demo.monitor import FrameRecorder
from tool0.cli.pick_demo.picker import pick_and_place
from tool0.description.camera import Camera, looking
from tool0.sensing.cameras import encode_png

CAMERA = Camera(
    name="readme",
    pose=looking((1.45, -0.75, 0.62), (0.42, -0.06, 0.13)),
    width=480,
    height=400,
    field_of_view=math.radians(40.0),
    far=20.0,
)
N_PICTURES = 4


def render() -> bytes:
    """Return some moments of a pick, side by side, as PNG."""
    recorder = FrameRecorder()
    with tool0.bringup(
        scene="table_and_bin", cameras=[CAMERA], realtime=False
    ) as robot:
        into = find_bin(robot.scene.objects, "bin")
        report = pick_and_place(robot, "cube", into, on_snapshot=recorder.record)
        if not report.success:
            sys.exit(f"the pick failed {report.failure}")
        moments = np.linspace(0.2, 0.98, N_PICTURES) * (len(recorder.frames) - 1)
        view = robot.camera(CAMERA.name)
        return encode_png(
            np.hstack([view.image(recorder.frames[round(k)]).rgb for k in moments])
        )


if __name__ == "__main__":
    Path(sys.argv[1]).write_bytes(render())
