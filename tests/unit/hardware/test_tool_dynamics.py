"""Newton and Euler for a part of a robot, against MuJoCo's own."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tool0.description.loading import assemble
from tool0.description.model import RobotModel
from tool0.description.scene_state import Contact
from tool0.engines.mujoco.engine import MujocoEngine
from tool0.errors import ModelError
from tool0.hardware.tool_dynamics import ToolDynamics


def joint_wrench(engine: MujocoEngine, link: str) -> np.ndarray:
    """Return what a movable link and all beyond it exert, as MuJoCo has it.

    In the link's axes, at its origin.
    """
    model, data = engine.model, engine.data
    mujoco.mj_forward(model, data)
    mujoco.mj_rnePostConstraint(model, data)
    body = model.body(link).id
    center = data.subtree_com[model.body_rootid[body]]
    force = data.cfrc_int[body][3:]
    torque = data.cfrc_int[body][:3] + np.cross(center - data.xpos[body], force)
    rotation = data.xmat[body].reshape(3, 3)
    return -np.concatenate([force @ rotation, torque @ rotation])


def check(model: RobotModel, link: str, seed: int) -> None:
    """Throw the robot about, and compare."""
    engine = MujocoEngine(model, ground=None)
    dynamics = ToolDynamics(model, link)
    rng = np.random.default_rng(seed)
    n = len(engine.joint_names)
    for _ in range(5):
        engine.reset(rng.uniform(-1.0, 1.0, n).tolist())
        engine.data.qvel[:] = rng.uniform(-1.0, 1.0, n)
        expected = joint_wrench(engine, link)
        state, acceleration = engine.read(), engine.data.qacc.tolist()
        wrench = dynamics.wrench(state.position, state.velocity, acceleration, ())
        np.testing.assert_allclose(wrench, expected, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("link", ["upper", "lower", "rod", "flap"])
def test_a_cut_anywhere_agrees_with_mujoco(skew_model: RobotModel, link: str) -> None:
    check(skew_model, link, seed=3)


def test_a_gripper_of_many_joints_agrees_with_mujoco() -> None:
    check(assemble("ur5", "2f85").model, "wrist_3_link", seed=4)


def test_a_cut_within_a_body_splits_its_inertia(skew_model: RobotModel) -> None:
    """Lower carries cap by a fixed joint: what is before the cut is nobody's load."""
    position = [0.3, -0.4, 0.1, 0.4]
    still = [0.0] * 4
    beyond = ToolDynamics(skew_model, "cap").wrench(position, still, still, ())
    assert np.linalg.norm(beyond[:3]) == pytest.approx((0.4 + 0.6) * 9.81)
    whole = ToolDynamics(skew_model, "lower").wrench(position, still, still, ())
    assert np.linalg.norm(whole[:3]) == pytest.approx((2.0 + 0.4 + 0.6 + 0.3) * 9.81)


def test_a_robot_that_stands_still_has_weight_too(skew_model: RobotModel) -> None:
    still = [0.0] * 4
    wrench = ToolDynamics(skew_model, "world").wrench(still, still, still, ())
    assert wrench[:3] == pytest.approx((0.0, 0.0, -(5.0 + 6.3) * 9.81))


def test_contacts_count_where_they_cross_the_cut(skew_model: RobotModel) -> None:
    dynamics = ToolDynamics(skew_model, "mount")
    still = [0.0] * 4
    alone = dynamics.wrench(still, still, still, ())
    point, force, torque = (1.0, 0.0, 0.0), (0.0, 0.0, 2.0), (0.1, 0.0, 0.0)
    pushed = Contact("wall", "mount", point, force, torque)
    pushes = Contact("rod", "wall", point, force, torque)
    inside = Contact("rod", "mount", point, force, torque)
    elsewhere = Contact("wall", "ground", point, force, torque)
    added = (0.0, 0.0, 2.0, 0.1, -2.0, 0.0)
    for contacts, sign in (((pushed, inside), 1.0), ((elsewhere, pushes), -1.0)):
        wrench = dynamics.wrench(still, still, still, contacts)
        np.testing.assert_allclose(np.subtract(wrench, alone), np.multiply(sign, added))


def test_an_unknown_link_is_refused(skew_model: RobotModel) -> None:
    with pytest.raises(ModelError) as error:
        ToolDynamics(skew_model, "cab")
    assert "'cap'" in str(error.value)
