from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from skew_robot import build_model

from tool0.description.model import Interface, JointLimits, RobotModel
from tool0.engines.mujoco.engine import MujocoEngine
from tool0.errors import ClaimError, ControlError, ModelError
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
    engine.set_brakes(hardware.brakes)
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
        assert state.position[:3] == pose[:3]


def test_a_moving_joint_is_stopped_when_it_is_released(skew_model: RobotModel) -> None:
    engine, hardware, state = rig(skew_model, POSES[0])
    hardware.claim(["lift"], Interface.EFFORT, state)
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
    hardware.claim(["lift", "bend", "slide"], Interface.POSITION, state)
    hardware.command[:3] = [1.0, -1.0, 0.1]
    speeds = [abs(step(engine, hardware, 1).velocity[0]) for _ in range(300)]
    assert max(speeds) < 3.0 * 1.25
    final = step(engine, hardware, 3000)
    np.testing.assert_allclose(final.position[:3], [1.0, -1.0, 0.1], atol=1e-3)


def test_a_velocity_interface_turns_at_its_command() -> None:
    engine, hardware, state = rig(build_model(Interface.VELOCITY), POSES[0])
    hardware.claim(["lift"], Interface.VELOCITY, state)
    hardware.command[0] = 0.5
    state = step(engine, hardware, 1500)
    assert state.velocity[0] == pytest.approx(0.5, rel=0.02)


def test_the_emergency_stop_holds_claimed_joints_too(skew_model: RobotModel) -> None:
    engine, hardware, state = rig(skew_model, POSES[1])
    hardware.claim(["lift", "bend", "slide"], Interface.EFFORT, state)
    hardware.set_stopped(True, state)
    hardware.command[0] = 100.0
    state = step(engine, hardware, 2000)
    np.testing.assert_allclose(state.position[:3], POSES[1][:3], atol=1e-3)


def test_limits_for_a_joint_without_drive_are_refused(skew_model: RobotModel) -> None:
    with pytest.raises(ModelError) as error:
        RobotHardware(skew_model, [], 0.001, {"slidde": JointLimits()})
    assert "'slide'" in str(error.value)


def test_the_claim_selects_how_a_joint_is_driven() -> None:
    model = build_model(Interface.POSITION, Interface.VELOCITY, Interface.EFFORT)
    engine, hardware, state = rig(model, POSES[0])
    hardware.claim(["lift"], Interface.POSITION, state)
    hardware.claim(["bend"], Interface.VELOCITY, state)
    assert hardware.claimed == {"lift": Interface.POSITION, "bend": Interface.VELOCITY}
    hardware.command[:2] = [0.3, 0.5]
    state = step(engine, hardware, 1500)
    assert state.position[0] == pytest.approx(0.3, abs=1e-3)
    assert state.velocity[1] == pytest.approx(0.5, rel=0.02)
    hardware.release(["lift"], state)
    hardware.claim(["lift"], Interface.EFFORT, state)
    hardware.command[0] = 17.0
    assert hardware.efforts(state)[0] == 17.0


def test_a_joint_is_commanded_through_one_interface_at_a_time() -> None:
    model = build_model(Interface.POSITION, Interface.VELOCITY)
    _, hardware, state = rig(model, POSES[0])
    hardware.claim(["lift"], Interface.POSITION, state)
    with pytest.raises(ClaimError, match=r"'lift'.*VelocityJointInterface.*Position"):
        hardware.claim(["bend", "lift"], Interface.VELOCITY, state)
    assert hardware.claimed == {"lift": Interface.POSITION}


def test_an_interface_that_the_drive_lacks_is_refused() -> None:
    _, hardware, state = rig(build_model(Interface.POSITION), POSES[0])
    with pytest.raises(ControlError, match=r"'lift'.*EffortJ.*: .*PositionJoint"):
        hardware.claim(["lift"], Interface.EFFORT, state)
    with pytest.raises(ControlError, match=r"'flap'.*interfaces: none"):
        hardware.claim(["flap"], Interface.POSITION, state)
    assert not hardware.claimed


def test_limits_of_the_commands_bound_the_drive() -> None:
    model = build_model(Interface.POSITION)
    limits = JointLimits(lower=-0.2, upper=0.2, velocity=0.5)
    drives = tuple(replace(item, command_limits=limits) for item in model.transmissions)
    engine, hardware, state = rig(replace(model, transmissions=drives), POSES[0])
    hardware.claim(["lift"], Interface.POSITION, state)
    hardware.command[0] = 1.0
    fastest = max(step(engine, hardware, 1).velocity[0] for _ in range(1500))
    assert 0.4 < fastest < 0.6
    assert engine.read().position[0] == pytest.approx(0.2, abs=1e-3)
    own = model.joint("lift").limits.effort
    assert hardware.limits["lift"] == replace(limits, effort=own)


def ripple(steps_per_command: int) -> tuple[float, float]:
    """Return how unevenly a joint follows a wave of sampled positions.

    That is the largest difference of its velocity from the wave's [rad/s], and that of
    its effort from one step to the next [N·m].
    """
    engine, hardware, state = rig(build_model(Interface.POSITION), POSES[0])
    hardware.set_steps_per_command(steps_per_command)
    hardware.claim(["lift"], Interface.POSITION, state)
    hardware.restart(state)
    errors, efforts = [], []
    for k in range(3000):
        if k % steps_per_command == 0:  # where the joint is to be at the next command
            hardware.command[0] = 0.3 * math.sin(2e-3 * (k + steps_per_command))
        state = step(engine, hardware, 1)
        errors.append(abs(state.velocity[0] - 0.6 * math.cos(2e-3 * (k + 1))))
        efforts.append(state.effort[0])
    return max(errors[500:]), float(np.abs(np.diff(efforts[500:])).max())


@pytest.mark.slow
@pytest.mark.parametrize("steps_per_command", [2, 4, 8])
def test_commands_of_a_longer_period_are_followed_as_smoothly(
    steps_per_command: int,
) -> None:
    error, jump = ripple(steps_per_command)
    assert error < 2.0 * ripple(1)[0]
    assert jump < 3.0
