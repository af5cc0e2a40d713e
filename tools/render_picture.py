"""Render the picture of the README: python tools/render_picture.py OUTPUT.png [POSE].

Needs a GL that renders off screen: MUJOCO_GL=egl or osmesa.
"""

from __future__ import annotations

import struct
import sys
import zlib
from pathlib import Path

import mujoco
import numpy as np

from tool0.description.catalogue import assemble, named_poses
from tool0.engines.mujoco.model import build_spec
from tool0.runtime.initial_pose import joint_positions

WIDTH, HEIGHT = 1280, 800


def render(pose: str) -> np.ndarray:
    """Return the default robot in ``pose``, shape (HEIGHT, WIDTH, 3), uint8."""
    description = assemble()
    spec = build_spec(description.model, dt=0.001, visuals=True, ground=0.0)
    spec.visual.global_.offwidth, spec.visual.global_.offheight = WIDTH, HEIGHT
    spec.visual.quality.shadowsize = 4096
    spec.visual.headlight.ambient = [0.3, 0.3, 0.3]
    spec.visual.headlight.diffuse = [0.3, 0.3, 0.3]
    spec.worldbody.add_light(
        pos=[0.2, -0.8, 3.0],
        dir=[0.05, 0.25, -1.0],
        cutoff=90.0,
        diffuse=[0.65, 0.65, 0.65],
    )
    sky = spec.add_texture(name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX)
    sky.builtin = mujoco.mjtBuiltin.mjBUILTIN_GRADIENT
    sky.rgb1, sky.rgb2 = [0.93, 0.95, 0.97], [0.8, 0.85, 0.9]
    sky.width, sky.height = 64, 384
    model = spec.compile()
    data = mujoco.MjData(model)
    joints = description.model.movable_joints
    data.qpos[: len(joints)] = joint_positions(
        description.model, named_poses(description)[pose], [0.0] * len(joints)
    )
    mujoco.mj_forward(model, data)
    camera = mujoco.MjvCamera()
    camera.lookat[:] = [0.30, 0.0, 0.30]
    camera.distance, camera.azimuth, camera.elevation = 1.1, 140.0, -16.0
    options = mujoco.MjvOption()
    options.geomgroup[:] = [1, 1, 1, 0, 0, 0]
    options.sitegroup[:] = 0
    with mujoco.Renderer(model, HEIGHT, WIDTH) as renderer:
        renderer.update_scene(data, camera, options)
        return renderer.render()


def write_png(path: Path, image: np.ndarray) -> None:
    """Write ``image``, shape (height, width, 3), uint8."""

    def chunk(kind: bytes, body: bytes) -> bytes:
        check = struct.pack(">I", zlib.crc32(kind + body))
        return struct.pack(">I", len(body)) + kind + body + check

    height, width, _ = image.shape
    rows = b"".join(b"\0" + row.tobytes() for row in image)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(rows, 9))
        + chunk(b"IEND", b"")
    )


if __name__ == "__main__":
    write_png(Path(sys.argv[1]), render(sys.argv[2] if len(sys.argv) > 2 else "home"))
