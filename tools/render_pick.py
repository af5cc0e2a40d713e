"""Render the animation of a pick: python tools/render_pick.py docs/images/pick.webp."""

from __future__ import annotations

import math
import sys
from typing import Any

import av

import tool0
from tool0.api.grasps import find_bin
from tool0.cli.demos.monitor import FrameRecorder
from tool0.cli.demos.picker import pick_and_place
from tool0.description.camera import Camera, looking

CAMERA = Camera(
    name="readme",
    pose=looking((1.55, -1.0, 0.72), (0.40, -0.02, 0.14)),
    width=1440,
    height=960,
    field_of_view=math.radians(36.0),
    far=20.0,
)
# half of the camera's size, for smooth edges
WIDTH, HEIGHT = CAMERA.width // 2, CAMERA.height // 2
FRAME_RATE = 12  # [Hz]
ENCODER = {"quality": "55", "compression_level": "6"}


def render(path: str) -> None:
    """Write a pick as an animated WebP in real time.  It repeats endlessly."""
    recorder = FrameRecorder(FRAME_RATE)
    simulation = tool0.SimulationConfig(
        scene="table_and_bin", cameras=(CAMERA,), realtime=False
    )
    with (
        tool0.bringup(simulation=simulation) as robot,
        av.open(path, "w", format="webp", options={"loop": "0"}) as container,
    ):
        into = find_bin(robot.scene.objects, "bin")
        report = pick_and_place(robot, "cube", into, on_snapshot=recorder.record)
        if not report.success:
            sys.exit(f"the pick failed {report.failure}")
        stream: Any = container.add_stream("libwebp_anim", FRAME_RATE, options=ENCODER)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        view = robot.camera(CAMERA.name)
        for snapshot in recorder.frames:
            frame = av.VideoFrame.from_ndarray(view.image(snapshot).rgb, format="rgb24")
            small = frame.reformat(WIDTH, HEIGHT, "yuv420p", interpolation="AREA")
            container.mux(stream.encode(small))
        container.mux(stream.encode(None))


if __name__ == "__main__":
    render(sys.argv[1])
