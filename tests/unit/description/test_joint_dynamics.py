from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tool0.description.bodies import JointDynamics
from tool0.description.model import RobotModel
from tool0.engines.mujoco.engine import MujocoEngine

MASTERS = np.array(
    [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0], [0, -0.5, 0]]
)  # d(lift, bend, slide, follower) / d(lift, bend, slide)


def random_pose(rng: np.random.Generator) -> list[float]:
    lift, bend = rng.uniform(-2.5, 2.5, size=2)
    return [lift, bend, rng.uniform(-0.2, 0.2), -0.5 * bend + 0.2]


@pytest.mark.parametrize("seed", range(8))
def test_gravity_and_mass_matrix_are_those_of_mujoco(
    skew_model: RobotModel, seed: int
) -> None:
    engine = MujocoEngine(skew_model)
    pose = random_pose(np.random.default_rng(seed))
    engine.reset(pose)
    mujoco.mj_forward(engine.model, engine.data)
    mass_matrix = np.zeros((4, 4))
    for column in range(4):  # M e_i, which every release of mujoco can give
        unit, product = np.eye(4)[column], np.zeros(4)
        mujoco.mj_mulM(engine.model, engine.data, product, unit)
        mass_matrix[:, column] = product
    dynamics = JointDynamics(skew_model)
    gravity = MASTERS.T @ engine.data.qfrc_bias
    expected = MASTERS.T @ mass_matrix @ MASTERS
    np.testing.assert_allclose(dynamics.static_effort(pose)[:3], gravity, atol=1e-9)
    np.testing.assert_allclose(dynamics.mass_matrix(pose)[:3, :3], expected, atol=1e-9)


@pytest.mark.parametrize(
    "gravity", [(0.0, 0.0, 0.0), (0.0, 0.0, 3.0), (1.0, 0.0, -2.0), (0.3, -7.0, 0.0)]
)
def test_gravity_may_point_anywhere(
    skew_model: RobotModel, gravity: tuple[float, float, float]
) -> None:
    engine = MujocoEngine(skew_model)
    engine.model.opt.gravity[:] = gravity
    pose = random_pose(np.random.default_rng(2))
    engine.reset(pose)
    assert engine.world.gravity == gravity
    dynamics = JointDynamics(skew_model, engine.world.gravity)
    expected = MASTERS.T @ engine.data.qfrc_bias
    np.testing.assert_allclose(dynamics.static_effort(pose)[:3], expected, atol=1e-9)
    matrix = JointDynamics(skew_model).mass_matrix(pose)
    np.testing.assert_allclose(dynamics.mass_matrix(pose), matrix, atol=1e-9)


def test_a_mimic_joint_bears_no_load_itself(skew_model: RobotModel) -> None:
    dynamics = JointDynamics(skew_model)
    pose = random_pose(np.random.default_rng(1))
    assert dynamics.static_effort(pose)[3] == 0.0
    assert not dynamics.mass_matrix(pose)[3].any()
