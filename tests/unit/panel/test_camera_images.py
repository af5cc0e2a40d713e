"""Images of the cameras over HTTP: rendered for those who ask, and only then."""

import http.client
import zlib
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from unittest.mock import patch
from urllib.parse import urlencode, urlsplit

import numpy as np
import pytest
from numpy.typing import NDArray
from promised import require_gl

import tool0
from tool0.panel.camera_images import depth_pixels
from tool0.panel.server import Panel
from tool0.protocol.sensors import CameraImage
from tool0.sensing.cameras import Cameras

TOKEN = "secret"


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    """A robot that moves only when a test lets time pass."""
    require_gl()
    with tool0.bringup(realtime=False) as robot:
        robot.run(1.0)
        yield robot


@pytest.fixture(scope="module")
def panel(robot: tool0.Robot) -> Iterator[Panel]:
    with Panel(robot, token=TOKEN) as panel:
        yield panel


def get(
    panel: Panel, path: str, token: str = TOKEN, **query: object
) -> tuple[http.client.HTTPResponse, bytes]:
    parts = urlsplit(panel.url)
    assert parts.hostname is not None
    connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=60.0)
    connection.request("GET", f"{path}?{urlencode({'token': token, **query})}")
    response = connection.getresponse()
    body = response.read()
    connection.close()
    return response, body


def number_of(response: http.client.HTTPResponse) -> int:
    return int(response.headers["x-image-number"])


def pixels_of(png: bytes) -> NDArray[np.uint8]:
    """Decode our own PNG: one chunk of data, each row filtered by "up"."""
    width, height = (int.from_bytes(png[i : i + 4], "big") for i in (16, 20))
    start = png.index(b"IDAT") + 4
    rows = np.frombuffer(zlib.decompress(png[start:]), np.uint8)
    rows = rows.reshape(height, 1 + 3 * width)[:, 1:]
    return np.cumsum(rows, axis=0, dtype=np.uint8).reshape(height, width, 3)


def taken(robot: tool0.Robot, name: str, width: int) -> CameraImage:
    camera = robot.simulation.cameras[name]
    height = width * camera.height // camera.width
    return robot.simulation.cameras.render(replace(camera, width=width, height=height))


def test_an_image_is_what_the_camera_sees(robot: tool0.Robot, panel: Panel) -> None:
    response, body = get(panel, "/cameras/wrist/color", width=160)
    assert response.status == 200
    assert response.headers["content-type"] == "image/png"
    assert response.headers["cache-control"] == "no-store"
    assert float(response.headers["x-image-time"]) == robot.time
    np.testing.assert_array_equal(pixels_of(body), taken(robot, "wrist", 160).rgb)


def test_depth_is_exact_to_the_millimetre(robot: tool0.Robot, panel: Panel) -> None:
    _, body = get(panel, "/cameras/scene/depth", width=160)
    pixels = pixels_of(body).astype(int)
    mm = pixels[..., 0] * 256 + pixels[..., 1]
    depth = taken(robot, "scene", 160).depth
    known = np.isfinite(depth)
    assert known.any()
    np.testing.assert_allclose(mm[known], 1000.0 * depth[known], atol=0.51)
    assert not mm[~known].any()


def test_unknown_and_far_depths_are_zero() -> None:
    depth = np.array([[np.inf, 70.0, 65.534, 0.0114]], np.float32)
    pixels = depth_pixels(depth).astype(int)
    assert (pixels[..., 0] * 256 + pixels[..., 1]).tolist() == [[0, 0, 65534, 11]]


def test_nothing_is_rendered_until_what_is_seen_changes(
    robot: tool0.Robot, panel: Panel
) -> None:
    first, _ = get(panel, "/cameras/scene/color", width=160)
    drawn = Cameras.render
    with patch.object(Cameras, "render", autospec=True, side_effect=drawn) as render:
        same, body = get(
            panel, "/cameras/scene/color", width=160, after=number_of(first)
        )
        assert (same.status, body) == (204, b"")
        # another page gets the image that there is
        again, _ = get(panel, "/cameras/scene/color", width=160)
        assert number_of(again) == number_of(first)
        assert render.call_count == 0
        robot.move_joints({"shoulder_pan_joint": robot.joint_state.time % 1.0})
        robot.run(0.2)
        moved, _ = get(panel, "/cameras/scene/color", width=160, after=number_of(first))
        assert moved.status == 200
        assert number_of(moved) > number_of(first)
        assert render.call_count == 1


def test_pages_that_ask_at_the_same_time_share_an_image(
    robot: tool0.Robot, panel: Panel
) -> None:
    robot.move_joints({"shoulder_pan_joint": -0.5})
    robot.run(0.1)
    drawn = Cameras.render
    with (
        patch.object(Cameras, "render", autospec=True, side_effect=drawn) as render,
        ThreadPoolExecutor(8) as pages,
    ):
        paths = ["/cameras/scene/color", "/cameras/scene/depth"] * 4
        answers = list(pages.map(lambda path: get(panel, path, width=192), paths))
    assert {response.status for response, _ in answers} == {200}
    assert len({number_of(response) for response, _ in answers}) == 1
    assert render.call_count == 1


@pytest.mark.parametrize(
    ("path", "query", "status", "text"),
    [
        ("/cameras/wirst/color", {}, 404, "did you mean 'wrist'?"),
        ("/cameras/wrist/colour", {}, 404, "ask for color or depth"),
        ("/cameras/wrist/color", {"width": 5000}, 400, "64 … 1280 pixels, got 5000"),
        ("/cameras/wrist/color", {"width": "wide"}, 400, "whole numbers"),
        ("/cameras/wrist/color", {"token": "no"}, 401, "token"),
    ],
)
def test_what_cannot_be_shown_is_refused_with_a_reason(
    panel: Panel, path: str, query: Mapping[str, object], status: int, text: str
) -> None:
    query = dict(query)
    response, body = get(panel, path, str(query.pop("token", TOKEN)), **query)
    assert response.status == status
    assert text in body.decode()
