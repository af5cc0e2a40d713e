"""MuJoCo behind the port: the laws of read, write, step and reset."""

from __future__ import annotations

import logging
import math
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from skew_robot import build_model

from tool0.description.catalogue import arms, grippers
from tool0.description.loading import assemble, named_poses
from tool0.description.model import RobotModel
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose
from tool0.engines.mujoco.engine import MujocoEngine
from tool0.errors import ConfigError, DivergenceError
from tool0.hardware.engine import Engine

CATALOGUE = [
    *((arm, None) for arm in arms()),
    *((arms()[0], gripper) for gripper in grippers()),
]


def home(arm: str, gripper: str | None) -> tuple[RobotModel, list[float]]:
    description = assemble(arm, gripper)
    pose = named_poses(description)["home"]
    return description.model, [
        pose.get(joint.name, 0.0) for joint in description.model.movable_joints
    ]


def test_what_is_reset_is_read_at_rest_at_time_zero(skew_model: RobotModel) -> None:
    engine: Engine = MujocoEngine(skew_model)
    for seed in range(3):
        pose = np.random.default_rng(seed).uniform(-0.2, 0.2, 4).tolist()
        engine.write([5.0, 5.0, 5.0, 0.0])
        engine.step()
        engine.reset(pose)
        state = engine.read()
        assert state.position == pose
        assert state.velocity == [0.0] * 4
        assert state.effort == [0.0] * 4
        assert state.time == 0.0


def test_time_is_the_number_of_steps(skew_model: RobotModel) -> None:
    engine: Engine = MujocoEngine(skew_model, dt=0.002)
    engine.reset([0.0, 0.0, 0.0, 0.2])
    for _ in range(1500):
        engine.step()
    assert engine.read().time == 1500 * 0.002
    assert engine.dt == 0.002


def test_a_state_is_a_copy_that_later_steps_leave_alone(skew_model: RobotModel) -> None:
    engine: Engine = MujocoEngine(skew_model)
    engine.reset([0.5, 0.0, 0.0, 0.2])
    effort = [1.0, 2.0, 3.0, 0.0]
    engine.write(effort)
    before = engine.read()
    kept = list(before.position)
    effort[0] = 99.0
    engine.step()
    assert before.position == kept
    assert engine.read().effort == [1.0, 2.0, 3.0, 0.0]


def test_a_free_fall_keeps_its_energy(skew_model: RobotModel) -> None:
    engine = MujocoEngine(skew_model, dt=1e-4, ground=None)
    engine.model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    engine.reset([0.4, -0.3, 0.0, 0.35])
    mujoco.mj_forward(engine.model, engine.data)
    start = engine.data.energy.sum()
    kinetic = 0.0
    for _ in range(1500):  # 0.15 s: long before the slide meets its stop
        engine.step()
        kinetic = max(kinetic, engine.data.energy[1])
    assert kinetic > 1.0  # [J]; it did fall
    assert abs(engine.data.energy.sum() - start) < 0.01 * kinetic


@pytest.mark.slow
@pytest.mark.parametrize(("arm", "gripper"), CATALOGUE)
def test_every_robot_steps_for_a_second_under_noise_without_a_warning(
    arm: str, gripper: str | None
) -> None:
    model, pose = home(arm, gripper)
    engine = MujocoEngine(model)
    engine.reset(pose)
    rng = np.random.default_rng(3)
    effort = np.array(
        [
            joint.limits.effort if joint.name in model.transmission_by_joint else 0.0
            for joint in model.movable_joints
        ]
    )
    for _ in range(1000):
        engine.write((effort * rng.uniform(-1.0, 1.0, len(pose))).tolist())
        engine.step()
        engine.read()  # raises if not finite
    counts = [warning.number for warning in engine.data.warning]
    assert counts == [0] * len(counts)


def test_an_effort_that_is_not_finite_is_an_error_that_names_joint_and_time(
    skew_model: RobotModel,
) -> None:
    engine = MujocoEngine(skew_model)
    engine.reset([0.0, 0.0, 0.0, 0.2])
    for _ in range(5):
        engine.step()
    with pytest.raises(DivergenceError) as error:
        engine.write([0.0, math.nan, 0.0, 0.0])
    assert (error.value.joint, error.value.time) == ("bend", 0.005)
    engine.step()
    assert engine.read().effort == [0.0] * 4


def test_a_state_that_is_not_finite_is_an_error_that_names_joint_and_time(
    skew_model: RobotModel,
) -> None:
    engine = MujocoEngine(skew_model)
    engine.reset([0.0, 0.0, 0.0, 0.2])
    engine.step()
    engine.data.qvel[2] = math.nan
    with pytest.raises(DivergenceError) as error:
        engine.read()
    assert (error.value.joint, error.value.time) == ("slide", 0.001)
    engine.reset([0.0, 0.0, 0.0, 0.2])
    assert engine.read().velocity == [0.0] * 4


@pytest.mark.parametrize("velocity", [-2e4, 1e145])
def test_an_absurd_velocity_is_a_divergence(
    skew_model: RobotModel, velocity: float
) -> None:
    engine = MujocoEngine(skew_model)
    engine.reset([0.0, 0.0, 0.0, 0.2])
    engine.data.qvel[:3] = 1.0, velocity, -5000.0
    with pytest.raises(DivergenceError) as error:
        engine.read()
    assert error.value.joint == engine.joint_names[1]
    engine.data.qvel[1] = 5000.0
    assert engine.read().velocity[1] == 5000.0


def test_a_divergence_writes_no_file(
    skew_model: RobotModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    engine = MujocoEngine(skew_model)
    engine.reset([0.0, 0.0, 0.0, 0.2])
    engine.data.qvel[:] = 1e145
    engine.step()  # MuJoCo warns of it
    assert [warning.number for warning in engine.data.warning if warning.number]
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("height", [0.0, -0.35])
def test_the_ground_lies_where_it_is_put(skew_model: RobotModel, height: float) -> None:
    engine = MujocoEngine(skew_model, ground=height)
    mujoco.mj_forward(engine.model, engine.data)
    assert engine.data.geom("ground").xpos[2] == height


def test_there_may_be_no_ground(skew_model: RobotModel) -> None:
    engine = MujocoEngine(skew_model, ground=None)
    assert engine.model.ngeom == 0


def test_a_pose_that_puts_shapes_into_each_other_is_a_warning(
    caplog: pytest.LogCaptureFixture,
) -> None:
    model, pose = home("ur5", None)
    engine = MujocoEngine(model, ground=0.0)
    with caplog.at_level(logging.WARNING):
        engine.reset(pose)
        assert caplog.records == []
        low = list(pose)
        low[1] = 0.6  # the upper arm points below the horizon
        engine.reset(low)
    messages = [record.getMessage() for record in caplog.records]
    assert any(
        message.endswith("into 'ground'; expect it to be pushed out")
        for message in messages
    )
    assert len(messages) == len(set(messages))
    assert all(message.startswith("the pose puts '") for message in messages)
    assert not any(message.startswith("the pose puts 'ground'") for message in messages)


def test_rotors_add_inertia_until_they_are_removed(skew_model: RobotModel) -> None:
    engine = MujocoEngine(skew_model)
    own = engine.model.dof_armature[:4].copy()
    engine.set_rotors({1: 0.5})
    cube = Box(size=(0.1, 0.1, 0.1))
    engine.world.spawn(SceneObject(name="cube", geometry=cube, pose=Pose(), mass=1.0))
    added = engine.model.dof_armature[:4] - own  # of another compiled model
    np.testing.assert_allclose(added, [0.0, 0.5, 0.0, 0.0], atol=1e-12)
    engine.set_rotors({})
    np.testing.assert_array_equal(engine.model.dof_armature[:4], own)


@pytest.mark.parametrize("dt", [0.0, -0.001, math.nan, math.inf])
def test_a_step_without_a_positive_length_is_refused(
    skew_model: RobotModel, dt: float
) -> None:
    with pytest.raises(ConfigError):
        MujocoEngine(skew_model, dt=dt)


def test_closing_twice_is_allowed() -> None:
    engine: Engine = MujocoEngine(replace(build_model(), name="again"))
    engine.close()
    engine.close()
