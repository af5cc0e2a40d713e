"""Coriolis and centrifugal efforts against MuJoCo's."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tool0.description.bodies import JointDynamics
from tool0.description.loading import assemble
from tool0.description.model import RobotModel
from tool0.description.velocity_torques import velocity_efforts
from tool0.engines.mujoco.engine import MujocoEngine

MASTERS = np.array(
    [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0], [0, -0.5, 0]]
)  # d(lift, bend, slide, follower) / d(lift, bend, slide)


def bias(engine: MujocoEngine, pose: list[float], velocity: list[float]) -> np.ndarray:
    """Return what MuJoCo adds to the weight for these velocities."""
    engine.reset(pose)
    mujoco.mj_forward(engine.model, engine.data)
    weight = engine.data.qfrc_bias.copy()
    engine.data.qvel[:] = velocity
    mujoco.mj_forward(engine.model, engine.data)
    return np.asarray(engine.data.qfrc_bias - weight)


@pytest.mark.parametrize("seed", range(8))
def test_efforts_are_those_of_mujoco(skew_model: RobotModel, seed: int) -> None:
    rng = np.random.default_rng(seed)
    lift, bend = rng.uniform(-2.5, 2.5, size=2)
    pose = [lift, bend, rng.uniform(-0.2, 0.2), -0.5 * bend + 0.2]
    velocity = (MASTERS @ rng.uniform(-3.0, 3.0, size=3)).tolist()
    expected = MASTERS.T @ bias(MujocoEngine(skew_model), pose, velocity)
    found = velocity_efforts(JointDynamics(skew_model), pose, velocity)
    np.testing.assert_allclose(found[:3], expected, atol=1e-9)
    assert found[3] == 0.0


@pytest.mark.parametrize("arm", ["ur3e", "ur5e", "ur10e"])
def test_efforts_of_an_arm_are_those_of_mujoco(arm: str) -> None:
    rng = np.random.default_rng(seed=3)
    model = assemble(arm, gripper=None).model
    engine, dynamics = MujocoEngine(model), JointDynamics(model)
    for _ in range(5):
        pose = rng.uniform(-3.0, 3.0, size=6).tolist()
        velocity = rng.uniform(-3.0, 3.0, size=6).tolist()
        found = velocity_efforts(dynamics, pose, velocity)
        np.testing.assert_allclose(found, bias(engine, pose, velocity), atol=1e-9)
