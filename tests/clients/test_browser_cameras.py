"""Windows with the live images of cameras: they change as the robot moves."""

from __future__ import annotations

import base64
import re
from dataclasses import replace

import numpy as np
import pytest
from browser import Tab, comes_to_rest, eventually
from promised import require_gl

import tool0
from tool0.sensing.cameras import Cameras

WIDTH = 320
"""Of the images [pixels]."""
PIXELS = """(canvas) => {
    const { width, height } = canvas;
    const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
    return btoa(Array.from(data, (one) => String.fromCharCode(one)).join(""));
}"""


def open_camera(tab: Tab, name: str) -> None:
    tab.get("scene-options").click()
    tab.get(f"camera-toggle-{name}").click()
    tab.get(f"camera-width-{name}").select_option(str(WIDTH))
    tab.see(f"[data-testid=camera-image-{name}][width='{WIDTH}'][data-count]")
    tab.get("scene-options").click()


def count(tab: Tab, name: str) -> int:
    """Return how many images a window has shown."""
    return int(tab.get(f"camera-image-{name}").get_attribute("data-count") or 0)


def image_time(tab: Tab, name: str) -> float:
    return float(tab.get(f"camera-image-{name}").get_attribute("data-time") or 0.0)


def shown(tab: Tab, name: str) -> np.ndarray:
    """Return what a window shows, shape (height, width, 3)."""
    canvas = tab.get(f"camera-image-{name}")
    size = [int(canvas.get_attribute(side) or 0) for side in ("height", "width")]
    data = np.frombuffer(base64.b64decode(canvas.evaluate(PIXELS)), np.uint8)
    return data.reshape(*size, 4)[..., :3]


def test_a_camera_is_live_while_it_is_open(
    robot: tool0.Robot, tab: Tab, monkeypatch: pytest.MonkeyPatch
) -> None:
    require_gl()
    rendered: list[float] = []
    render = Cameras.render

    def counted(self: Cameras, *arguments: object) -> object:
        image = render(self, *arguments)  # type: ignore[arg-type]  # passed on
        rendered.append(image.time)
        return image

    monkeypatch.setattr(Cameras, "render", counted)
    comes_to_rest(robot)
    assert not rendered, "nobody looks"
    open_camera(tab, "scene")
    comes_to_rest(robot)
    before = shown(tab, "scene")
    start = count(tab, "scene"), len(rendered)
    robot.move_joints({"shoulder_pan_joint": 1.5}, duration=60.0)
    eventually(lambda: count(tab, "scene") >= start[0] + 5, "five more images")
    # every image that is rendered is shown: the page asks for the next one only then
    n_rendered = len(rendered) - start[1]
    assert count(tab, "scene") - start[0] >= n_rendered - 2
    robot.move_joints({"shoulder_pan_joint": 1.0}, speed=1.0)
    comes_to_rest(robot)
    robot.pause()
    eventually(
        lambda: image_time(tab, "scene") == max(rendered), "the last image is shown"
    )
    after = shown(tab, "scene")
    assert (np.abs(after.astype(int) - before) > 30).any(axis=2).sum() > 500
    camera = robot.simulation.cameras["scene"]
    sized = replace(camera, width=WIDTH, height=WIDTH * camera.height // camera.width)
    expected = robot.simulation.cameras.render(sized).rgb
    assert np.abs(after.astype(int) - expected).mean() < 1.0
    tab.get("camera-close-scene").click()
    tab.get("camera-scene").wait_for(state="detached")


def test_depth_has_a_scale_and_a_reading(robot: tool0.Robot, tab: Tab) -> None:
    require_gl()
    open_camera(tab, "scene")
    tab.get("camera-depth-scene").click()
    scale = tab.page.locator("[data-testid=camera-scene] .camera-scale")
    scale.wait_for()
    ends = [float(x) for x in re.findall(r"\d+\.\d+", scale.text_content() or "")]
    box = tab.get("camera-image-scene").bounding_box()
    assert box is not None
    x, y = 0.5, 0.75
    tab.page.mouse.move(box["x"] + x * box["width"], box["y"] + y * box["height"])
    reading = tab.get("camera-depth-here-scene")
    reading.filter(has_text=re.compile(r"\d m")).wait_for()
    camera = robot.simulation.cameras["scene"]
    sized = replace(camera, width=WIDTH, height=WIDTH * camera.height // camera.width)
    depth = robot.simulation.cameras.render(sized).depth
    row, column = int(y * sized.height), int(x * sized.width)
    here = depth[row - 2 : row + 3, column - 2 : column + 3]
    shown_depth = float((reading.text_content() or "").split()[0])
    assert here.min() - 0.002 <= shown_depth <= here.max() + 0.002
    known = depth[np.isfinite(depth)]
    assert ends[0] == pytest.approx(np.quantile(known, 0.01), abs=0.02)
    assert ends[1] == pytest.approx(np.quantile(known, 0.9), abs=0.1)
