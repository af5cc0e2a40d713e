"""Cameras: the wrist's image, the position of a pixel, and a video of a motion.

The video needs an extra package: `pip install '.[video]'`.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import tool0
from tool0.scene import Camera, looking

SIDE = Camera(  # in addition to `wrist` and `scene`, which every arm has
    name="side",
    pose=looking((0.6, -1.2, 0.4), at=(0.5, 0.0, 0.1)),
    width=320,
    height=240,
)

simulation = tool0.SimulationConfig(
    scene="table_and_cubes", cameras=(SIDE,), realtime=False
)
with (
    TemporaryDirectory() as folder,
    tool0.bringup(initial_pose="ready", simulation=simulation) as robot,
):
    image = robot.camera("wrist").image()
    Path(folder, "wrist.png").write_bytes(tool0.encode_png(image.rgb))

    # Compute the position of the red cube's upper face, which is between the fingers.
    red, green, blue = np.moveaxis(image.rgb.astype(int), -1, 0)
    rows, columns = np.nonzero(red > 3 * np.maximum(green, blue))
    u, v = round(columns.mean()), round(rows.mean())
    x, y, one = np.linalg.inv(image.K) @ (u, v, 1.0)
    z = float(image.depth[v, u])
    seen = image.T_root_camera.apply((x * z, y * z, z))
    print("seen at    ", " ".join(f"{part:+.3f}" for part in seen), "m")
    position = robot.scene.pose("red cube").position
    print("its middle:", " ".join(f"{part:+.3f}" for part in position), "m")

    # Snapshots can be drawn later, so that a video does not slow down the motion.
    goals = robot.go_to_pose("home")
    snapshots = []
    while goals[0].result is None:
        snapshots.append(robot.snapshot)
        robot.run(0.04)
    try:
        with tool0.VideoWriter(Path(folder, "home.mp4"), 320, 240, fps=25.0) as video:
            for snapshot in snapshots:
                video.write(robot.camera("side").image(snapshot).rgb)
        print(f"a video of {len(snapshots)} pictures")
    except tool0.RenderError as error:
        print("no video:", error)  # the extra package is not installed
