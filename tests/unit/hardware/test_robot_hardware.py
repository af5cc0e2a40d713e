from __future__ import annotations

import numpy as np
import pytest
from skew_robot import build_model

from tool0.description.model import Interface, JointLimits, RobotModel
from tool0.engines.mujoco.engine import MujocoEngine
from tool0.errors import ModelError
from tool0.hardware.engine import Engine, JointState
from tool0.hardware.robot_hardware import RobotHardware

POSES = [[0.0, 0.0, 0.0, 0.2], [1.5, -1.0, 0.1, 0.7], [-2.0, 2.0, -0.15, -0.8]]


def rig(
    model: RobotModel, pose: list[float]
) -> tuple[Engine, RobotHardware, JointState]:
    engine: Engine = MujocoEngine(model)
    engine.reset(pose)
    hardware = RobotHardware(model, engine.joint_names, engine.dt)
    state = engine.read()
    hardware.restart(state)
    return engine, hardware, state


def step(engine: Engine, hardware: RobotHardware, n_steps: int) -> JointState:
    for _ in range(n_steps):
        engine.write(hardware.efforts(engine.read()))
        engine.step()
    return engine.read()


@pytest.mark.parametrize("pose", POSES)
def test_an_unclaimed_joint_stays_where_it_is(
    skew_model: RobotModel, pose: list[float]
) -> None:
    engine, hardware, _ = rig(skew_model, pose)
    for _ in range(10):
        state = step(engine, hardware, 1000)
        assert np.abs(np.subtract(state.position, pose))[:3].max() <= 1e-3


def test_a_moving_joint_is_stopped_when_it_is_released(skew_model: RobotModel) -> None:
    engine, hardware, state = rig(skew_model, POSES[0])
    hardware.claim(["lift"], state)
    hardware.command[0] = 100.0
    moving = step(engine, hardware, 100)
    assert moving.velocity[0] > 0.5
    hardware.release(["lift"], moving)
    step(engine, hardware, 1000)
    rest = step(engine, hardware, 1000)
    assert abs(rest.velocity[0]) < 1e-3
    after = step(engine, hardware, 1000)
    assert after.position[0] == pytest.approx(rest.position[0], abs=1e-4)


def test_a_position_interface_follows_no_faster_than_its_limit() -> None:
    engine, hardware, state = rig(build_model(Interface.POSITION), POSES[0])
    hardware.claim(["lift", "bend", "slide"], state)
    hardware.command[:3] = [1.0, -1.0, 0.1]
    speeds = [abs(step(engine, hardware, 1).velocity[0]) for _ in range(300)]
    assert max(speeds) < 3.0 * 1.25
    final = step(engine, hardware, 3000)
    np.testing.assert_allclose(final.position[:3], [1.0, -1.0, 0.1], atol=1e-3)


def test_a_velocity_interface_turns_at_its_command() -> None:
    engine, hardware, state = rig(build_model(Interface.VELOCITY), POSES[0])
    hardware.claim(["lift"], state)
    hardware.command[0] = 0.5
    state = step(engine, hardware, 1500)
    assert state.velocity[0] == pytest.approx(0.5, rel=0.02)


def test_the_emergency_stop_holds_claimed_joints_too(skew_model: RobotModel) -> None:
    engine, hardware, state = rig(skew_model, POSES[1])
    hardware.claim(["lift", "bend", "slide"], state)
    hardware.set_stopped(True, state)
    hardware.command[0] = 100.0
    state = step(engine, hardware, 2000)
    np.testing.assert_allclose(state.position[:3], POSES[1][:3], atol=1e-3)


def test_limits_for_a_joint_without_drive_are_refused(skew_model: RobotModel) -> None:
    with pytest.raises(ModelError) as error:
        RobotHardware(skew_model, [], 0.001, {"slidde": JointLimits()})
    assert "'slide'" in str(error.value)
