"""Coarse meshes: near those that they replace, and only where pixels are wide."""

from __future__ import annotations

import numpy as np
import pytest
from promised import require_gl

from tool0.description.camera import Camera, looking
from tool0.description.config import DescriptionConfig
from tool0.description.loading import load_description
from tool0.description.model import RobotModel
from tool0.engines.mujoco import rendering
from tool0.engines.mujoco.detail import CELL, Shape, simplified
from tool0.engines.mujoco.rendering import NOTHING, Renderer

pytestmark = pytest.mark.slow

LOOK_AT = (0.0, 0.0, 0.4)


def ball(n: int) -> Shape:
    """Return a sphere of radius 1 with n rings of n corners."""
    turn, rise = np.meshgrid(
        np.linspace(0.0, 2.0 * np.pi, n, endpoint=False),
        np.linspace(-0.49 * np.pi, 0.49 * np.pi, n),
    )
    points = np.stack(
        [np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)], axis=2
    )
    number = np.arange(n * n).reshape(n, n)
    first, second = number[:-1], np.roll(number, -1, axis=1)[:-1]
    third, fourth = np.roll(number, -1, axis=1)[1:], number[1:]
    faces = [np.stack(x, 2) for x in ((first, second, third), (first, third, fourth))]
    return Shape(points.reshape(-1, 3), np.reshape(faces, (-1, 3)))


@pytest.mark.parametrize("cell", [0.05, 0.2, 0.5])
def test_a_coarse_shape_is_within_a_cell_of_the_fine_one(cell: float) -> None:
    fine = ball(60)
    coarse = simplified(fine, cell)
    assert 0 < len(coarse.faces) < len(fine.faces)
    corners = coarse.points[np.unique(coarse.faces)]
    for some, others in ((corners, fine.points), (fine.points, corners)):
        away = np.linalg.norm(some[:, None] - others, axis=2).min(axis=1)
        assert away.max() <= np.sqrt(3.0) * cell
    sides = coarse.points[coarse.faces]
    normals = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
    outwards = (normals * sides.mean(axis=1)).sum(axis=1)
    assert (outwards > -1e-9).mean() > 0.95  # no side is turned over


def test_tiny_cells_change_nothing() -> None:
    fine = ball(8)
    coarse = simplified(fine, 1e-6)
    same = np.sort(coarse.points[coarse.faces].reshape(-1, 9), axis=0)
    assert same == pytest.approx(np.sort(fine.points[fine.faces].reshape(-1, 9), 0))


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    require_gl()
    return load_description(DescriptionConfig(gripper="2f85")).model


def drawn(robot: RobotModel, distance: float, side: int) -> tuple[np.ndarray, int]:
    """Return what an image shows, and the number of triangles of it."""
    eye = (distance, 0.3 * distance, 0.5)
    camera = Camera(name="c", pose=looking(eye, LOOK_AT), width=side, height=side)
    at_rest = {joint.name: 0.0 for joint in robot.movable_joints}
    renderer = Renderer(robot, None, side, side)
    found = renderer.segment(camera, at_rest, (), ())
    visible, model = renderer._visible, renderer._model
    meshes = [g.dataid // 2 for g in visible.geoms[: visible.ngeom] if g.dataid >= 0]
    renderer.close()
    return found, int(model.mesh_facenum[meshes].sum())


def test_a_small_image_has_fewer_triangles_and_the_same_outline(
    robot: RobotModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    coarse, n_coarse = drawn(robot, 1.6, 96)
    monkeypatch.setattr(rendering, "add_coarse", lambda spec: None)
    fine, n_fine = drawn(robot, 1.6, 96)
    assert n_coarse < 0.7 * n_fine
    shown = (fine != NOTHING).sum()
    assert shown > 500
    assert (coarse != fine).sum() < 0.03 * shown


def test_details_that_a_pixel_can_show_are_kept(
    robot: RobotModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    pixel = 2.0 * np.tan(np.pi / 8.0) / 640  # per metre of distance, with 45 degrees
    assert pixel * 1.6 < CELL
    near, n_near = drawn(robot, 1.6, 640)
    monkeypatch.setattr(rendering, "add_coarse", lambda spec: None)
    fine, n_fine = drawn(robot, 1.6, 640)
    assert n_near == n_fine
    assert np.array_equal(near, fine)
