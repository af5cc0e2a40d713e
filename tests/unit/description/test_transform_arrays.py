"""Laws of many rotations at once: those of one, and inverses undo."""

from __future__ import annotations

import numpy as np
import pytest

from tool0.description.transform import (
    Transform,
    from_quaternion,
    from_rotation_vector,
    rotate_by,
    to_pose,
)
from tool0.description.transform_arrays import (
    Array,
    Frames,
    cross_matrices,
    from_quats,
    from_rotation_vectors,
    matrix_of,
    quats_wxyz,
    rotated_by,
    rotation_vector,
    rotations_about,
    sine_vectors,
    to_rpy,
    turn_z_to,
)

N = 60


@pytest.fixture
def vectors() -> Array:
    """Rotation vectors, also very short ones and those of half turns."""
    rng = np.random.default_rng(8)
    directions = rng.normal(size=(N, 3))
    directions[:3] = np.eye(3)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    sizes = rng.choice([0.0, 1e-13, 1e-9, 1e-5, 1.0, 3.0, np.pi - 1e-7, np.pi], (N, 1))
    sizes[:3] = np.pi
    return np.asarray(directions * sizes)


def one_by_one(vectors: Array) -> list[Transform]:
    origin = (0.0, 0.0, 0.0)
    return [from_rotation_vector(origin, vector) for vector in vectors.tolist()]


def test_rotation_vectors_come_back(vectors: Array) -> None:
    for vector, T in zip(vectors, one_by_one(vectors), strict=True):
        found = np.array(T.rotation_vector)
        assert np.linalg.norm(found) <= np.pi + 1e-12
        if not np.linalg.norm(found - vector) < 1e-9:  # at pi, both signs are right
            assert np.linalg.norm(vector) > np.pi - 1e-9
            np.testing.assert_allclose(found, -vector, atol=1e-9)
        np.testing.assert_array_equal(rotation_vector(T.matrix[:3, :3]), found)
    pose = (0.1, -0.2, 0.3, 1.0, -2.0, 0.5)
    T = from_rotation_vector(pose[:3], pose[3:])
    assert (*T.position, *T.rotation_vector) == pytest.approx(pose, abs=1e-15)
    np.testing.assert_array_equal(matrix_of(pose), T.matrix)


def test_many_are_as_one(vectors: Array) -> None:
    R = from_rotation_vectors(vectors)
    quats, angles = quats_wxyz(R), to_rpy(R)
    sines = sine_vectors(R)
    for k, T in enumerate(one_by_one(vectors)):
        np.testing.assert_allclose(R[k], T.rotation, atol=1e-14)
        same = quats[k] @ T.quat_wxyz  # at half turns, both signs are right
        assert abs(same) == pytest.approx(1.0, abs=1e-14)
        assert quats[k, 0] >= 0.0
        np.testing.assert_allclose(angles[k], to_pose(T).rpy, atol=1e-8)
        angle = np.linalg.norm(vectors[k])
        axis = vectors[k] / angle if angle else vectors[k]
        np.testing.assert_allclose(sines[k], 2 * np.sin(angle) * axis, atol=1e-12)


def test_inverses_undo(vectors: Array) -> None:
    R = from_rotation_vectors(vectors)
    np.testing.assert_allclose(from_quats(-3.0 * quats_wxyz(R)), R, atol=1e-14)
    opposite = from_rotation_vectors(-vectors)
    np.testing.assert_allclose(R @ opposite, np.tile(np.eye(3), (N, 1, 1)), atol=1e-14)
    position = np.random.default_rng(0).normal(size=(N, 3))
    frames = Frames(position, R)
    for product in (frames @ frames.inverse(), frames.inverse() @ frames):
        np.testing.assert_allclose(product.position, np.zeros((N, 3)), atol=1e-14)
        np.testing.assert_allclose(
            product.rotation, np.tile(np.eye(3), (N, 1, 1)), atol=1e-14
        )


def test_frames_compose_as_transforms(vectors: Array) -> None:
    position = np.random.default_rng(1).normal(size=(N, 3))
    frames = Frames(position, from_rotation_vectors(vectors))
    other = frames @ frames
    fixed = from_quaternion((0.1, 0.2, 0.3), (1.0, 2.0, 3.0, 4.0))
    carried = frames @ fixed
    for k in range(N):
        rotation = tuple(map(tuple, frames.rotation[k].tolist()))
        T = Transform(position=tuple(position[k].tolist()), rotation=rotation)  # type: ignore[arg-type]
        for found, expected in ((other, T @ T), (carried, T @ fixed)):
            np.testing.assert_allclose(found.position[k], expected.position, atol=1e-14)
            np.testing.assert_allclose(found.rotation[k], expected.rotation, atol=1e-14)


def test_quaternions_rotate_as_one_to_the_bit(vectors: Array) -> None:
    quats = quats_wxyz(from_rotation_vectors(vectors))
    points = np.random.default_rng(2).normal(size=(N, 3))
    found = rotated_by(quats, points)
    matrices = from_quats(quats)
    for k in range(N):
        q, point = tuple(quats[k].tolist()), tuple(points[k].tolist())
        np.testing.assert_array_equal(found[k], rotate_by(q, point))
        np.testing.assert_allclose(found[k], matrices[k] @ points[k], atol=1e-14)


def test_rotations_about_axes_are_those_of_rotation_vectors() -> None:
    rng = np.random.default_rng(3)
    axes = rng.normal(size=(N, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    angles = rng.uniform(-np.pi, np.pi, N)
    K = cross_matrices(axes)
    np.testing.assert_allclose(
        rotations_about(K, K @ K, angles),
        from_rotation_vectors(angles[:, None] * axes),
        atol=1e-14,
    )
    u = rng.normal(size=3)
    np.testing.assert_allclose(K @ u, np.cross(axes, u), atol=1e-15)


@pytest.mark.parametrize("axis", [*np.eye(3), *-np.eye(3), [0.6, 0.0, -0.8]])
def test_z_is_turned_to_an_axis(axis: Array) -> None:
    R = turn_z_to(axis)
    np.testing.assert_allclose(R[:, 2], axis)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(R) == pytest.approx(1.0)
