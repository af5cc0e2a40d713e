"""Render all built-in arms side by side at one scale, for docs/reference/robots.md.

Usage: python tools/render_arms.py OUTPUT.webp.  Without a display, set MUJOCO_GL to egl
or osmesa.
"""

from __future__ import annotations

import re
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any  # Any: objects of MuJoCo

import mujoco
import numpy as np
from numpy.typing import NDArray
from webp import encode_webp

from tool0.description.catalogue import arms
from tool0.description.loading import load_robot
from tool0.engines.mujoco.gl import make_context
from tool0.engines.mujoco.model import build_spec

POSE = {
    "shoulder_lift_joint": -1.85,
    "elbow_joint": 1.95,
    "wrist_1_joint": -1.67,
    "wrist_2_joint": -1.5708,
}
PIXELS_PER_METRE = 263
SAMPLES = 3
"""Number of rendered pixels for each pixel of the picture, in both directions."""
WIDTH = 1560
YAW = 0.55
"""Angle by which every arm is turned toward the camera [rad]."""
ELEVATION = 14.0
"""Elevation of the camera above the horizon [deg]."""
ABOVE, BELOW = 0.08, 0.34
"""Margins above an arm, and below its foot including the label [m]."""
INK = (0.20, 0.24, 0.28)
"""Color of the labels."""

Image = NDArray[np.uint8]


def rows() -> list[list[str]]:
    """Return the arms in two rows, sorted by generation and size."""
    series = sorted(arms(), key=_order)
    half = (len(series) + 1) // 2
    return [series[:half], series[half:]]


def _order(name: str) -> tuple[int, int]:
    size = int(re.sub(r"\D", "", name))
    is_e_series = name.endswith("e")
    return (1 if is_e_series else 0 if size <= 10 else 2, size)


def scene(names: Sequence[str], places: Sequence[float]) -> Any:
    """Return the MuJoCo model and data of arms at ``places`` [m] along y."""
    macros = "\n".join(
        f'<xacro:ur_arm prefix="{name}_" parent="world" model="{name}">'
        f'<origin xyz="0 {y} 0" rpy="0 0 {YAW - 1.5708}"/></xacro:ur_arm>'
        for name, y in zip(names, places, strict=True)
    )
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "arms.urdf.xacro")
        file.write_text(
            '<robot name="arms" xmlns:xacro="http://www.ros.org/wiki/xacro">'
            '<xacro:include filename="$(find tool0_description)/urdf/ur_macro.xacro"/>'
            f'<link name="world"/>{macros}</robot>',
            encoding="utf-8",
        )
        spec = build_spec(load_robot(file).model, dt=0.001, visuals=True, ground=None)
    _furnish(spec)
    model = spec.compile()
    data = mujoco.MjData(model)
    for name in names:
        for joint, position in POSE.items():
            data.joint(f"{name}_{joint}").qpos[0] = position
    mujoco.mj_forward(model, data)
    return model, data


def _furnish(spec: Any) -> None:
    """Add a white floor, a white sky and a light from above."""
    spec.visual.global_.offwidth = WIDTH * SAMPLES
    spec.visual.global_.offheight = 2000
    spec.visual.global_.orthographic = 1
    spec.visual.headlight.ambient = [0.36, 0.36, 0.36]
    spec.visual.headlight.diffuse = [0.36, 0.36, 0.36]
    spec.visual.headlight.specular = [0.08, 0.08, 0.08]
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
        rgb1=[1, 1, 1],
        rgb2=[1, 1, 1],
        width=64,
        height=64 * 6,
    )
    spec.worldbody.add_light(
        pos=[3.0, 1.0, 6.0],
        dir=[-0.35, -0.15, -1.0],
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        castshadow=False,
        diffuse=[0.45, 0.45, 0.45],
        specular=[0.15, 0.15, 0.15],
    )


def extent(name: str) -> tuple[float, float, float]:
    """Return the lowest y, the highest y and the height of an arm at the origin [m]."""
    model, data = scene([name], [0.0])
    corners = []
    for geom in np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_MESH):
        mesh = model.geom_dataid[geom]
        first = model.mesh_vertadr[mesh]
        vertices = model.mesh_vert[first : first + model.mesh_vertnum[mesh]]
        rotation = data.geom_xmat[geom].reshape(3, 3)
        corners.append(vertices @ rotation.T + data.geom_xpos[geom])
    low, high = np.min(np.vstack(corners), axis=0), np.max(np.vstack(corners), axis=0)
    return float(low[1]), float(high[1]), float(high[2])


def render(names: Sequence[str]) -> Image:
    """Return the picture of one row of arms, with labels."""
    extents = [extent(name) for name in names]
    width = WIDTH / PIXELS_PER_METRE
    gap = (width - sum(high - low for low, high, _ in extents)) / len(names)
    places, labels, edge = [], [], gap / 2
    for low, high, _ in extents:
        places.append(edge - low)
        labels.append(edge + (high - low) / 2)
        edge += high - low + gap
    top = max(high for _, _, high in extents) + ABOVE
    height = int((top + BELOW) * PIXELS_PER_METRE)
    model, data = scene(names, places)
    model.vis.global_.fovy = height / PIXELS_PER_METRE
    context = make_context(WIDTH * SAMPLES, height * SAMPLES)
    context.make_current()
    drawing = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_300.value)
    mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, drawing)
    visible = mujoco.MjvScene(model, maxgeom=10_000)
    camera = mujoco.MjvCamera()
    camera.orthographic = 1
    camera.azimuth, camera.elevation, camera.distance = 180.0, -ELEVATION, 4.0
    camera.lookat[:] = (0.0, width / 2, (top - BELOW) / 2)
    options = mujoco.MjvOption()
    options.geomgroup[:] = [1, 1, 1, 0, 0, 0]
    options.sitegroup[:] = 0
    mujoco.mjv_updateScene(
        model, data, options, None, camera, mujoco.mjtCatBit.mjCAT_ALL.value, visible
    )
    view = mujoco.MjrRect(0, 0, WIDTH * SAMPLES, height * SAMPLES)
    mujoco.mjr_render(view, visible, drawing)
    font = mujoco.mjtFont.mjFONT_BIG
    for name, middle in zip(names, labels, strict=True):
        text = name.replace("ur", "UR")
        advances = [drawing.charWidthBig[ord(letter)] for letter in text]
        x = (middle / width) - sum(advances) / (2 * WIDTH * SAMPLES)
        mujoco.mjr_text(font.value, text, drawing, x, 0.12 / (top + BELOW), *INK)
    pixels = np.empty((height * SAMPLES, WIDTH * SAMPLES, 3), np.uint8)
    mujoco.mjr_readPixels(pixels, None, view, drawing)
    drawing.free()
    context.free()
    blocks = pixels[::-1].reshape(height, SAMPLES, WIDTH, SAMPLES, 3)
    return np.asarray(blocks.mean(axis=(1, 3)).round(), np.uint8)


if __name__ == "__main__":
    picture = np.concatenate([render(row) for row in rows()])
    Path(sys.argv[1]).write_bytes(encode_webp(picture))
