"""One posture in plain floats: the same as many by numpy."""

from __future__ import annotations

import numpy as np
import pytest

from tool0.description.catalogue import arms
from tool0.description.config import DescriptionConfig
from tool0.description.robot import load_description
from tool0.kinematics.chain import find_chains
from tool0.kinematics.one_posture import OnePostureChain, parts_of, rotated, times
from tool0.kinematics.pose import matrix_of, rotation_of, rotation_vector_of

N = 50


@pytest.mark.parametrize("arm", arms())
def test_postures_agree(arm: str) -> None:
    rng = np.random.default_rng(seed=7)
    model = load_description(DescriptionConfig(arm=arm, gripper=None)).model
    (chain,) = find_chains(model).values()
    T_base_chain = matrix_of(rng.uniform(-1.0, 1.0, size=6))
    one = OnePostureChain(chain, T_base_chain)
    q = rng.uniform(-2.0 * np.pi, 2.0 * np.pi, size=(N, 6))
    qd = rng.uniform(-3.0, 3.0, size=(N, 6))
    many = chain.forward(q)
    R_base_chain, p = T_base_chain[:3, :3], T_base_chain[:3, 3]
    point = (0.01, -0.02, 0.15)
    for k in range(N):
        posture = one.forward(q[k].tolist())
        T = T_base_chain @ many.T_base_tip[k]
        expected = parts_of(T)
        np.testing.assert_allclose(posture.R, expected[0], atol=1e-14)
        np.testing.assert_allclose(posture.p, expected[1], atol=1e-14)
        np.testing.assert_allclose(
            posture.points, p + many.points[k] @ R_base_chain.T, atol=1e-14
        )
        np.testing.assert_allclose(
            posture.axes, many.axes[k] @ R_base_chain.T, atol=1e-14
        )
        tool = posture.at(point)
        np.testing.assert_allclose(tool, (T @ [*point, 1.0])[:3], atol=1e-14)
        linear, angular = posture.velocity(posture.p, qd[k].tolist())
        twist = many.jacobian[k] @ qd[k]
        np.testing.assert_allclose(linear, R_base_chain @ twist[:3], atol=1e-12)
        np.testing.assert_allclose(angular, R_base_chain @ twist[3:], atol=1e-12)


def test_rotations() -> None:
    rng = np.random.default_rng(seed=8)
    for _ in range(N):
        vector = rng.normal(size=3)
        vector *= rng.choice([1e-9, 1.0, np.pi - 1e-7, np.pi]) / np.linalg.norm(vector)
        R = rotation_of(vector)
        rows = tuple(R.ravel().tolist())
        found = np.array(rotation_vector_of(rows))  # type: ignore[arg-type]
        if not np.linalg.norm(found - vector) < 1e-7:  # at pi, both signs are right
            np.testing.assert_allclose(found, -vector, atol=1e-7)
        other = rotation_of(rng.normal(size=3))
        product = times(rows, tuple(other.ravel().tolist()))  # type: ignore[arg-type]
        np.testing.assert_allclose(product, (R @ other).ravel(), atol=1e-15)
        np.testing.assert_allclose(
            rotated(rows, (1.0, 2.0, 3.0)),  # type: ignore[arg-type]
            R @ [1.0, 2.0, 3.0],
            atol=1e-14,
        )
    assert rotation_vector_of((1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)) == (0,) * 3
