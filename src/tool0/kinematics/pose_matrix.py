"""Poses as people give them, as the matrices that kinematics computes with."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from tool0.description.kinematics import Transform, to_transform
from tool0.description.model import Pose
from tool0.errors import ModelError

AnyPose = Transform | Pose | Iterable[Sequence[float]]
"""A pose; anything else is a homogeneous matrix, shape (4, 4)."""


def as_matrix(pose: AnyPose) -> NDArray[np.float64]:
    """Return a pose as a homogeneous matrix, shape (4, 4).

    A rotation that is rounded is put right.

    Raises:
        ModelError: If it is no pose.
    """
    if isinstance(pose, Pose):
        pose = to_transform(pose)
    if isinstance(pose, Transform):
        pose = pose.matrix
    try:
        T = np.array(pose, dtype=float)
    except (TypeError, ValueError):
        raise ModelError(
            f"a pose must be a Transform, a Pose or a (4, 4) array, got {pose!r:.80}"
        ) from None
    if T.shape != (4, 4) or not np.isfinite(T).all():
        raise ModelError(
            f"a pose must be finite and of shape (4, 4), got {T.shape}: {T.tolist()}"
        )
    R = T[:3, :3]
    is_rotation = np.abs(R @ R.T - np.eye(3)).max() < 1e-3 and np.linalg.det(R) > 0
    if not is_rotation or np.abs(T[3] - [0, 0, 0, 1]).max() > 1e-9:
        raise ModelError(
            "the array is no pose: need a rotation above left and 0 0 0 1 below, "
            f"got {T.tolist()}"
        )
    U, _, Vt = np.linalg.svd(R)
    T[:3, :3] = U @ Vt
    return T


def as_transform(T: NDArray[np.float64]) -> Transform:
    """Return a homogeneous matrix, shape (4, 4), as a transform."""
    rows = T[:3, :3].tolist()
    return Transform(
        position=tuple(T[:3, 3].tolist()),
        rotation=tuple(tuple(row) for row in rows),  # type: ignore[arg-type]
    )
