"""One posture in plain floats: the same as many by numpy."""

from __future__ import annotations

import numpy as np
import pytest

from tool0.description.catalogue import arms
from tool0.description.config import DescriptionConfig
from tool0.description.loading import load_description
from tool0.description.transform_arrays import matrix_of
from tool0.kinematics.chain import find_chains
from tool0.kinematics.scalar_kinematics import ScalarChain

N = 50


@pytest.mark.slow
@pytest.mark.parametrize("arm", arms())
def test_postures_agree(arm: str) -> None:
    rng = np.random.default_rng(seed=7)
    model = load_description(DescriptionConfig(arm=arm, gripper=None)).model
    (chain,) = find_chains(model).values()
    T_base_chain = matrix_of(rng.uniform(-1.0, 1.0, size=6))
    one = ScalarChain(chain, T_base_chain)
    q = rng.uniform(-2.0 * np.pi, 2.0 * np.pi, size=(N, 6))
    qd = rng.uniform(-3.0, 3.0, size=(N, 6))
    many = chain.forward(q)
    R_base_chain, p = T_base_chain[:3, :3], T_base_chain[:3, 3]
    for k in range(N):
        posture = one.forward(q[k].tolist())
        T = T_base_chain @ many.T_base_tip[k]
        np.testing.assert_allclose(posture.flange.matrix, T, atol=1e-14)
        np.testing.assert_allclose(
            posture.points, p + many.points[k] @ R_base_chain.T, atol=1e-14
        )
        np.testing.assert_allclose(
            posture.axes, many.axes[k] @ R_base_chain.T, atol=1e-14
        )
        linear, angular = posture.velocity(posture.flange.position, qd[k].tolist())
        twist = many.jacobian[k] @ qd[k]
        np.testing.assert_allclose(linear, R_base_chain @ twist[:3], atol=1e-12)
        np.testing.assert_allclose(angular, R_base_chain @ twist[3:], atol=1e-12)
