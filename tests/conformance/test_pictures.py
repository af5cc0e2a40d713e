"""Cameras draw what the engine has, whichever it is."""

from __future__ import annotations

import numpy as np
import pytest
from conformance_types import BringUp
from promised import require_gl

from tool0.description.camera import Camera, looking
from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose

EDGE = 0.1
CUBE = SceneObject(
    name="cube",
    geometry=Box(size=(EDGE,) * 3),
    mass=0.5,
    pose=Pose(xyz=(0.5, 0.3, 0.2)),
    rgba=(0.0, 1.0, 0.0, 1.0),
)
ABOVE = Camera(
    name="above",
    pose=looking((0.5, 0.3, 1.5), (0.5, 0.3, 0.0), up=(1.0, 0.0, 0.0)),
    width=320,
    height=240,
)


def test_what_falls_is_seen_where_it_is(bring_up: BringUp) -> None:
    require_gl()
    robot = bring_up(scene=Scene((CUBE,)), cameras=[ABOVE])
    view = robot.camera("above")
    for _ in range(3):
        image = view.image()
        x, y, z = robot.scene.pose("cube").position
        assert image.time == robot.snapshot.time
        u, v, w = image.K @ image.T_root_camera.inverse().apply((x, y, z + EDGE / 2))
        red, green, blue = np.moveaxis(image.rgb.astype(int), -1, 0)
        rows, columns = np.nonzero((green > 2 * red) & (green > 2 * blue))
        assert (columns.mean(), rows.mean()) == pytest.approx((u / w, v / w), abs=0.5)
        assert image.depth[rows, columns] == pytest.approx(w, abs=1e-3)
        robot.run(0.2)
    assert z == pytest.approx(-0.1 + EDGE / 2, abs=2e-3)  # it lies on the ground
    assert image.depth[0, 0] == pytest.approx(1.6, abs=1e-4)


def test_a_camera_on_the_arm_goes_with_it(bring_up: BringUp) -> None:
    require_gl()
    robot = bring_up()
    robot.move_joints({"wrist_1_joint": -1.0}, speed=1.0)[0].wait()
    image = robot.camera("wrist").image()
    expected = robot.pose("tool0") @ robot.camera("wrist").camera.T_link_camera
    assert image.T_root_camera.matrix == pytest.approx(expected.matrix, abs=1e-6)
