"""Pictures: what is where in them, and how far away."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from promised import require_gl

from tool0.description.camera import Camera, looking
from tool0.description.forward_kinematics import link_pose
from tool0.description.model import (
    Collision,
    Joint,
    JointType,
    Link,
    RobotModel,
    Visual,
)
from tool0.description.scene import SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.shapes import Box, Compound, Cylinder, Mesh, Sphere
from tool0.description.transform import Pose, Transform, to_pose, to_transform
from tool0.engines.mujoco.gl import PACKAGES as GL_PACKAGES
from tool0.engines.mujoco.rendering import (
    Renderer,
    shadow_size,
    with_readable_visuals,
)
from tool0.errors import RenderError

pytestmark = pytest.mark.slow

EYE = (5.0, 5.0, 5.0)  # far from the robot
CAMERA = Camera(name="c", pose=looking(EYE, (6.0, 5.0, 5.0)), width=160, height=120)
RED, GREEN = (1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, 1.0)

Look = Callable[..., tuple[NDArray[np.uint8], NDArray[np.float32], Transform]]


@pytest.fixture
def renderer(skew_model: RobotModel) -> Iterator[Renderer]:
    require_gl()
    renderer = Renderer(skew_model, None, CAMERA.width, CAMERA.height)
    yield renderer
    renderer.close()


@pytest.fixture
def look(renderer: Renderer, skew_model: RobotModel) -> Look:
    """Return what draws objects where they begin, or at other states."""
    rest = {joint.name: 0.0 for joint in skew_model.movable_joints}

    def look(
        *objects: SceneObject,
        states: tuple[ObjectState, ...] | None = None,
        camera: Camera = CAMERA,
        **position: float,
    ) -> tuple[NDArray[np.uint8], NDArray[np.float32], Transform]:
        return renderer.render(
            camera,
            {**rest, **position},
            objects,
            states or tuple(state_of(item) for item in objects),
        )

    return look


def state_of(item: SceneObject) -> ObjectState:
    frame = to_transform(item.pose)
    return ObjectState(item.name, frame.position, frame.quat_wxyz)


def ahead(x: float = 0.0, y: float = 0.0, z: float = 1.0) -> tuple[float, float, float]:
    """Return a point of the optical frame in the root."""
    return CAMERA.T_link_camera.apply((x, y, z))


def middle_of(mask: NDArray[np.bool_]) -> tuple[float, float]:
    """Return the mean pixel (u, v)."""
    rows, columns = np.nonzero(mask)
    return float(columns.mean()), float(rows.mean())


def is_green(rgb: NDArray[np.uint8]) -> NDArray[np.bool_]:
    red, green, blue = np.moveaxis(rgb.astype(int), -1, 0)
    return (green > 2 * red) & (green > 2 * blue)


@pytest.mark.parametrize("tilt_deg", [0.0, 30.0, 60.0])
def test_the_depth_of_a_tilted_face_is_exact(look: Look, tilt_deg: float) -> None:
    tilt = Transform(
        rotation=to_transform(Pose(rpy=(0.0, math.radians(tilt_deg), 0.0))).rotation
    )
    plate = Box(size=(0.02, 3.0, 3.0))
    T_root_plate = Transform(position=ahead(z=1.0)) @ tilt
    item = SceneObject(name="plate", geometry=plate, pose=to_pose(T_root_plate))
    _, depth, T_root_camera = look(item)
    # The face that is nearer: -x of the plate.
    normal = np.array(T_root_plate.rotation) @ (-1.0, 0.0, 0.0)
    in_camera = np.array(T_root_camera.rotation).T
    normal = in_camera @ normal
    on_face = in_camera @ (np.array(T_root_plate.apply((-0.01, 0.0, 0.0))) - EYE)
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    rays = np.stack([u, v, np.ones_like(u)], -1) @ np.linalg.inv(CAMERA.intrinsics).T
    expected = (normal @ on_face) / (rays @ normal)
    seen = np.isfinite(depth) & (expected > 0.0) & (expected < 2.0)
    assert seen.mean() > 0.5
    assert np.abs(depth - expected)[seen].max() < 1e-5  # 1e-3 would do


@pytest.mark.parametrize(("x", "y"), [(0.0, 0.0), (-0.3, 0.1), (0.25, -0.2)])
def test_a_thing_is_at_the_pixel_that_the_intrinsics_say(
    look: Look, x: float, y: float
) -> None:
    item = SceneObject(
        name="disc",
        geometry=Cylinder(radius=0.05, length=0.001),  # no part hides another
        pose=Pose(xyz=ahead(x, y), rpy=(0.0, math.pi / 2, 0.0)),
        rgba=GREEN,
    )
    rgb, depth, _ = look(item)
    u, v, _ = CAMERA.intrinsics @ (x, y, 1.0)
    assert middle_of(is_green(rgb)) == pytest.approx((u, v), abs=0.1)
    assert middle_of(np.isfinite(depth)) == pytest.approx((u, v), abs=0.1)


def test_every_part_of_an_object_is_seen_where_it_is(look: Look) -> None:
    ball = Sphere(radius=0.05)
    sides = (Pose(xyz=(0.0, 0.3, 0.0)), Pose(xyz=(0.0, -0.3, 0.0)))
    item = SceneObject(
        name="dumbbell",
        geometry=Compound(parts=tuple((ball, side) for side in sides)),
        pose=Pose(xyz=ahead()),
        rgba=GREEN,
    )
    rgb, _, _ = look(item)
    green = is_green(rgb)
    middle = CAMERA.width // 2
    assert green[:, :middle].any()
    assert green[:, middle:].any()
    assert not green[:, middle - 10 : middle + 10].any()


def test_nothing_within_reach_is_infinitely_far(look: Look) -> None:
    item = SceneObject(
        name="far", geometry=Sphere(radius=1.0), pose=Pose(xyz=ahead(z=9))
    )
    _, depth, _ = look(item)
    assert np.isinf(depth[0, 0])
    assert depth[60, 80] == pytest.approx(8.0, abs=0.01)  # facets
    short = Camera(name="s", pose=CAMERA.pose, width=160, height=120, far=7.0)
    _, depth, _ = look(item, camera=short)
    assert np.isposinf(depth).all()


def test_things_are_drawn_where_they_are_now_and_leave(look: Look) -> None:
    ball = SceneObject(name="ball", geometry=Sphere(radius=0.1), mass=1.0, rgba=GREEN)
    post = SceneObject(name="post", geometry=Sphere(radius=0.1), rgba=GREEN)
    for item in (ball, post):  # on a free joint, and fixed
        for y in (-0.2, 0.2):
            state = ObjectState(item.name, ahead(y=y), (1.0, 0.0, 0.0, 0.0))
            rgb, _, _ = look(item, states=(state,))
            _, v, _ = CAMERA.intrinsics @ (0.0, y, 1.0)
            assert middle_of(is_green(rgb))[1] == pytest.approx(v, abs=3.0)
    rgb, depth, _ = look()
    assert not is_green(rgb).any()
    assert np.isinf(depth).all()


def test_a_camera_on_a_link_goes_with_it(look: Look, skew_model: RobotModel) -> None:
    link = skew_model.movable_joints[0].child
    mounted = Pose(xyz=(0.1, 0.2, 0.3), rpy=(0.4, 0.5, 0.6))
    camera = Camera(name="c", link=link, pose=mounted, width=8, height=8)
    for lift in (0.0, 0.7):
        *_, T_root_camera = look(camera=camera, lift=lift)
        expected = link_pose(skew_model, {"lift": lift}, link) @ to_transform(mounted)
        assert T_root_camera.matrix == pytest.approx(expected.matrix, abs=1e-9)


def test_the_ground_is_where_it_is(skew_model: RobotModel) -> None:
    require_gl()
    renderer = Renderer(skew_model, -0.5, 16, 16)
    up = (1.0, 0.0, 0.0)
    camera = Camera(
        name="c", pose=looking((3, 3, 1), (3, 3, 0), up), width=16, height=16
    )
    _, depth, _ = renderer.render(
        camera, {joint.name: 0.0 for joint in skew_model.movable_joints}, (), ()
    )
    renderer.close()
    assert depth == pytest.approx(np.full((16, 16), 1.5), abs=1e-5)


def test_the_ground_is_below_a_camera_far_away(skew_model: RobotModel) -> None:
    require_gl()
    renderer = Renderer(skew_model, 0.25, 24, 16)
    pose = looking((300.0, -70.0, 2.0), (302.0, -68.0, 1.6))
    camera = Camera(name="c", pose=pose, width=24, height=16, far=90.0)
    at_rest = {joint.name: 0.0 for joint in skew_model.movable_joints}
    _, depth, frame = renderer.render(camera, at_rest, (), ())
    renderer.close()
    rows, columns = np.mgrid[:16, :24]
    (fx, _, cx), (_, fy, cy), _ = camera.intrinsics
    x, y = (columns - cx) / fx, (rows - cy) / fy
    right, down, forward = frame.rotation[2]
    falling = -(right * x + down * y + forward)  # per metre of depth
    with np.errstate(divide="ignore"):
        expected = np.where(falling > 0.0, 1.75 / falling, np.inf)
    is_near = expected < 30.0
    assert is_near.any()
    assert depth[is_near] == pytest.approx(expected[is_near], rel=1e-3)


def test_collision_shapes_stand_in_for_meshes_that_mujoco_cannot_read(
    caplog: pytest.LogCaptureFixture,
) -> None:
    ball, disc = Sphere(radius=0.3), Cylinder(radius=0.3, length=0.1)
    collada = Mesh(uri="hand.dae", path=Path("hand.dae"))
    links = (
        Link(name="arm", visuals=(Visual(geometry=disc),)),
        Link(
            name="hand",
            visuals=(Visual(geometry=collada),),
            collisions=(Collision(geometry=ball),),
        ),
    )
    joint = Joint(name="wrist", type=JointType.FIXED, parent="arm", child="hand")
    model = RobotModel(name="r", root="arm", links=links, joints=(joint,))
    found = with_readable_visuals(model)
    assert [visual.geometry for link in found.links for visual in link.visuals] == [
        disc,
        ball,
    ]
    assert "hand.dae" in caplog.text
    assert with_readable_visuals(found) is found


def test_without_opengl_it_is_told_what_to_install(
    skew_model: RobotModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.delenv("PYOPENGL_PLATFORM", raising=False)
    monkeypatch.setattr("sys.platform", "linux")

    def no_library(name: str) -> None:
        raise OSError(name)

    monkeypatch.setattr("ctypes.CDLL", no_library)
    with pytest.raises(RenderError) as error:
        Renderer(skew_model, None, 8, 8)
    assert GL_PACKAGES in str(error.value)


@pytest.mark.parametrize("word", ["disable", "vulkan"])
def test_a_mujoco_gl_that_draws_nothing_is_named(
    skew_model: RobotModel, monkeypatch: pytest.MonkeyPatch, word: str
) -> None:
    monkeypatch.setenv("MUJOCO_GL", word)
    with pytest.raises(RenderError) as error:
        Renderer(skew_model, None, 8, 8)
    assert f"'{word}'" in str(error.value)


@pytest.mark.parametrize("command", ["bringup --headless", "describe mjcf"])
def test_a_wrong_mujoco_gl_is_no_traceback(command: str) -> None:
    # In a process of its own: MuJoCo looks at it when it is imported.
    ended = subprocess.run(
        [sys.executable, "-m", "tool0", *command.split()],
        env={**os.environ, "MUJOCO_GL": "nonsense"},
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )
    assert ended.returncode == 2
    (line,) = ended.stderr.splitlines()
    assert line.startswith("tool0: error: ")
    assert "MUJOCO_GL, which is 'nonsense'" in line


def test_small_images_have_small_shadow_maps() -> None:
    sizes = [shadow_size(*size) for size in ((96, 96), (160, 120), (640, 480))]
    assert sizes == [512, 1024, 2048]
