"""Stops of a real arm, on the reports of a robot without a network."""

from __future__ import annotations

import pytest
from raises_naming import raises_naming
from still_robot import StillRobotRig, still_robot

from tool0.control.manager import Strictness
from tool0.errors import ControlError
from tool0.protocol.control_box_state import ProgramState
from tool0.simulation.executor import Executor

FOLLOWER = "eff_joint_traj_controller"
PLAY = "tool0 hardware play"


@pytest.fixture
def rig(monkeypatch: pytest.MonkeyPatch) -> StillRobotRig:
    return still_robot(monkeypatch)


def move(rig: StillRobotRig) -> None:
    Executor(rig.core).move_joints({"elbow_joint": 0.1}, 0.3, None)


def start(rig: StillRobotRig) -> None:
    rig.core.manager.switch([FOLLOWER], (), Strictness.STRICT, rig.core.state)


def test_the_controllers_of_a_stopped_arm_wait_for_play(rig: StillRobotRig) -> None:
    move(rig)
    rig.arm.stop(rig.core.state)
    for refused in (move, start):
        with raises_naming(ControlError, "the arm 'arm' has stopped; ", PLAY):
            refused(rig)
    rig.arm.play(rig.core.state)
    assert rig.core.manager.status(FOLLOWER).is_running
    move(rig)


def test_the_remedy_of_an_arm_that_must_be_enabled_is_to_enable_it(
    rig: StillRobotRig,
) -> None:
    rig.robot.write("runtime_state", 1)
    rig.ticks(1)
    assert rig.state.motion_failure == "tool0's program on the robot has ended"
    with raises_naming(ControlError, "tool0 hardware enable"):
        move(rig)


def test_a_stop_keeps_its_reason_until_the_program_is_played(
    rig: StillRobotRig,
) -> None:
    reason = "something is in the way"
    rig.engine.guard = lambda motion, now: reason
    move(rig)
    rig.ticks(1)
    assert rig.state.motion_failure == reason
    rig.robot.write("actual_digital_input_bits", 1)
    rig.ticks(1)
    assert rig.state.digital_inputs[0]
    assert (rig.state.motion_failure, rig.state.program) == (
        *(reason, ProgramState.STOPPED),
    )
    with raises_naming(ControlError, reason, PLAY):
        move(rig)
    rig.engine.guard = lambda motion, now: ""
    rig.arm.play(rig.core.state)
    rig.ticks(2)
    assert not rig.state.motion_failure
    assert rig.state.program is ProgramState.PLAYING


def test_a_reason_that_returns_in_the_tick_after_play_is_kept(
    rig: StillRobotRig,
) -> None:
    reason = "something is where the arm is"
    rig.engine.guard = lambda motion, now: reason
    move(rig)
    rig.ticks(3)
    assert rig.state.motion_failure == reason
    rig.arm.play(rig.core.state)
    assert not rig.state.motion_failure
    rig.ticks(1)
    assert rig.state.motion_failure == reason
    assert rig.state.program is ProgramState.STOPPED
