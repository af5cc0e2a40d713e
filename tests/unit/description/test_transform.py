"""Laws of rigid transforms, against the algebra of matrices."""

import math
import subprocess
import sys

import numpy as np
import pytest

from tool0.description.transform import (
    Pose,
    Transform,
    as_matrix,
    cross,
    from_matrix,
    from_quaternion,
    pose_matrix,
    to_pose,
    to_transform,
)
from tool0.errors import ModelError


def random_transforms(n: int, seed: int) -> list[Transform]:
    rows = np.random.default_rng(seed).uniform(-3, 3, size=(n, 6)).tolist()
    return [to_transform(Pose(xyz=tuple(r[:3]), rpy=tuple(r[3:]))) for r in rows]


HALF_TURNS = [to_transform(Pose(rpy=tuple(row))) for row in math.pi * np.eye(3)]
GIMBAL_LOCK = [
    to_transform(Pose(rpy=(0.3, pitch, -0.8))) for pitch in (math.pi / 2, -math.pi / 2)
]


def assert_same(actual: Transform, expected: Transform, atol: float = 1e-12) -> None:
    np.testing.assert_allclose(actual.matrix, expected.matrix, atol=atol)


def test_composition_is_that_of_matrices_and_inverses_undo() -> None:
    a_b_c = random_transforms(150, seed=0)
    for a, b, c in zip(a_b_c[::3], a_b_c[1::3], a_b_c[2::3], strict=True):
        np.testing.assert_allclose((a @ b).matrix, a.matrix @ b.matrix, atol=1e-12)
        assert_same((a @ b) @ c, a @ (b @ c))
        assert_same(a @ a.inverse(), Transform())
        assert_same(a.inverse() @ a, Transform())
        assert_same((a @ b).inverse(), b.inverse() @ a.inverse())


def test_points_move_and_vectors_only_turn() -> None:
    for T in random_transforms(20, seed=1):
        v = (1.0, 2.0, 3.0)
        np.testing.assert_allclose((*T.apply(v), 1), T.matrix @ (*v, 1), atol=1e-12)
        np.testing.assert_allclose((*T.rotate(v), 0), T.matrix @ (*v, 0), atol=1e-12)


def test_rotations_keep_lengths_and_vector_products() -> None:
    for T in random_transforms(20, seed=2):
        a, b = (1.0, -2.0, 0.5), (0.3, 0.4, -1.0)
        assert math.hypot(*T.rotate(a)) == pytest.approx(math.hypot(*a))
        assert T.rotate(cross(a, b)) == pytest.approx(cross(T.rotate(a), T.rotate(b)))
        assert np.linalg.det(np.array(T.rotation)) == pytest.approx(1.0)


def test_rpy_is_about_fixed_axes() -> None:
    roll, pitch, yaw = 0.3, -0.7, 2.0
    about_z, about_y, about_x = (
        to_transform(Pose(rpy=rpy))
        for rpy in ((0.0, 0.0, yaw), (0.0, pitch, 0.0), (roll, 0.0, 0.0))
    )
    T = to_transform(Pose(rpy=(roll, pitch, yaw)))
    assert_same(T, about_z @ about_y @ about_x)


def test_matrices_quaternions_and_poses_of_urdf_come_back() -> None:
    for T in [*HALF_TURNS, *GIMBAL_LOCK, *random_transforms(100, seed=3)]:
        w, x, y, z = T.quat_wxyz
        assert w >= 0
        assert math.hypot(w, x, y, z) == pytest.approx(1)
        longer = [-3.0 * part for part in (w, x, y, z)]
        assert_same(from_quaternion(T.position, longer), T)
        assert_same(to_transform(to_pose(T)), T, atol=1e-8)
        np.testing.assert_array_equal(pose_matrix(to_pose(T))[:3, 3], T.position)
        assert from_matrix(T.matrix) == T
        np.testing.assert_allclose(as_matrix(T), T.matrix, atol=1e-12)
        np.testing.assert_allclose(as_matrix(to_pose(T)), T.matrix, atol=1e-8)


def test_a_rounded_rotation_is_made_orthogonal() -> None:
    (T,) = random_transforms(1, seed=4)
    R = as_matrix(T.matrix.round(5).tolist())[:3, :3]
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize(
    "wrong",
    [
        np.diag([-1.0, 1.0, 1.0, 1.0]),  # a mirror
        2.0 * np.eye(4),
        np.eye(3),
        np.full((4, 4), np.nan),
        Transform(position=(math.nan, 0.0, 0.0)),
        "here",
        None,
    ],
)
def test_what_is_no_pose_is_refused(wrong: object) -> None:
    with pytest.raises(ModelError):
        as_matrix(wrong)  # type: ignore[arg-type]


def test_a_transform_prints_short() -> None:
    T = Transform(position=(1.0, -1e-12, 0.25))
    assert repr(T) == "Transform(position=(1, 0, 0.25), quat_wxyz=(1, 0, 0, 0))"


def test_numpy_is_not_imported_before_a_matrix_is_needed() -> None:
    code = (
        "import sys; from tool0.description import camera, rigid_model, urdf; "
        "sys.exit('numpy' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
