"""Cameras as values: where they look, and where a point comes to lie."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tool0.description.camera import Camera, default_cameras, looking, merged
from tool0.description.loading import assemble
from tool0.description.model import RobotModel
from tool0.description.transform import Pose, to_transform
from tool0.errors import ConfigError

COORDINATE = st.floats(-5.0, 5.0)
POINT = st.tuples(COORDINATE, COORDINATE, COORDINATE)


@given(position=POINT, at=POINT)
def test_what_is_looked_at_is_straight_ahead_and_up_is_up(
    position: tuple[float, float, float], at: tuple[float, float, float]
) -> None:
    sideways = math.hypot(at[0] - position[0], at[1] - position[1])
    if sideways < 1e-3:
        return  # straight up or down: nothing says what is up in the picture
    T_root_camera = to_transform(looking(position, at))
    assert T_root_camera.inverse().apply(at) == pytest.approx(
        (0.0, 0.0, math.dist(position, at)), abs=1e-6
    )
    right, down, _ = zip(*T_root_camera.rotation, strict=True)
    assert right[2] == pytest.approx(0.0, abs=1e-9)  # the horizon is level
    assert down[2] < 0.0
    assert np.linalg.det(np.array(T_root_camera.rotation)) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("at", "up"),
    [((1, 2, 3), (0, 0, 1)), ((1, 2, 8), (0, 0, 2)), ((4, 4, 4), (0,) * 3)],
)
def test_what_cannot_be_looked_at_is_refused(
    at: tuple[float, float, float], up: tuple[float, float, float]
) -> None:
    with pytest.raises(ConfigError):
        looking((1.0, 2.0, 3.0), at, up)


def test_the_corners_of_the_view_come_to_the_corners_of_the_picture() -> None:
    camera = Camera(name="c", width=200, height=100, field_of_view=math.radians(60.0))
    up = math.tan(math.radians(30.0))
    for x, y in ((-1, -1), (1, -1), (-1, 1), (1, 1)):
        u, v, one = camera.intrinsics @ (2.0 * up * x, up * y, 1.0)
        assert one == 1.0
        # Pixels have their middles at whole numbers, so their edges at halves.
        assert (u, v) == pytest.approx((100 * x + 99.5, 50 * y + 49.5))


BAD_FIELDS: list[dict[str, object]] = [
    {"name": ""},
    {"name": "a/b"},
    {"pose": Pose(xyz=(math.nan, 0.0, 0.0))},
    {"width": 0},
    {"height": 99.5},
    {"height": 5000},
    *({"field_of_view": value} for value in (0.0, math.pi, math.nan)),
    {"near": 0.0},
    {"near": 1.0, "far": 0.5},
    {"far": math.inf},
]


@pytest.mark.parametrize("wrong", BAD_FIELDS, ids=str)
def test_a_camera_that_cannot_be_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ConfigError) as caught:
        Camera(**{"name": "c", **wrong})  # type: ignore[arg-type]
    assert f"'{wrong.get('name', 'c')}'" in str(caught.value)


def test_a_link_that_is_not_there_is_told_with_the_nearest() -> None:
    model = assemble().model
    with pytest.raises(ConfigError) as caught:
        Camera(name="c", link="tool00").check_on(model)
    assert "'c'" in str(caught.value)
    assert "'tool0'" in str(caught.value)
    Camera(name="c", link="tool0").check_on(model)
    Camera(name="c").check_on(model)


def test_robots_with_one_flange_have_a_camera_on_it(skew_model: RobotModel) -> None:
    assert [camera.name for camera in default_cameras(skew_model)] == ["scene"]
    wrist, scene = default_cameras(assemble(prefix="left_").model)
    assert (wrist.name, wrist.link) == ("wrist", "left_tool0")
    assert (scene.name, scene.link) == ("scene", None)


def test_the_scene_is_seen_from_in_front_of_the_arm() -> None:
    *_, scene = default_cameras(assemble().model)
    assert scene.pose.xyz == pytest.approx((1.35, -0.95, 0.85))  # it reaches along x


def test_of_two_groups_the_later_one_counts() -> None:
    first, second, other = Camera(name="a"), Camera(name="a", width=8), Camera(name="b")
    assert merged([first, other], [second]) == {"a": second, "b": other}
    with pytest.raises(ConfigError):
        merged([first, second])
