"""Power, brakes, protective stops and programs of an arm."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from ur5_rig import ARM

import tool0
from tool0.description.config import DescriptionConfig
from tool0.errors import ControlError, GoalRejectedError
from tool0.protocol.control_box_state import ProgramState, RobotMode, SafetyMode

ELBOW = {"elbow_joint": 1.0}


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False) as robot:
        yield robot


def running(robot: tool0.Robot) -> set[str]:
    return {item.name for item in robot.snapshot.controllers if item.is_running}


def speed(robot: tool0.Robot) -> float:
    return max(map(abs, robot.snapshot.velocity))


def test_a_powered_off_arm_is_braked_until_it_is_powered_and_played(
    robot: tool0.Robot,
) -> None:
    box, before = robot.arm.control_box, running(robot)
    goal, *_ = robot.move_joints(ELBOW)
    robot.run(0.3)
    assert speed(robot) > 0.1
    box.power_off()
    assert goal.status.is_terminal
    assert box.state.robot_mode is RobotMode.POWER_OFF
    assert box.state.safety_mode is SafetyMode.NORMAL
    assert box.state.program is ProgramState.STOPPED
    assert not box.state.is_program_running
    assert before - running(robot) == {ARM}
    robot.run(0.5)
    assert speed(robot) < 1e-3
    with pytest.raises(ControlError, match="powered off"):
        box.play()
    box.power_on()
    assert box.state.robot_mode is RobotMode.IDLE
    with pytest.raises(ControlError, match="braked"):
        box.play()
    box.release_brakes()
    assert box.state.robot_mode is RobotMode.RUNNING
    assert not box.state.is_program_running
    assert ARM not in running(robot)
    box.play()
    assert box.state.is_program_running
    assert running(robot) == before
    assert robot.move_joints(ELBOW)[0].wait(5.0)


def test_brakes_are_released_from_off_and_twice(robot: tool0.Robot) -> None:
    box = robot.arm.control_box
    before = box.state
    box.power_on()
    box.release_brakes()
    assert box.state == before
    box.power_off()
    box.release_brakes()
    assert box.state.robot_mode is RobotMode.RUNNING


def test_nothing_starts_the_controllers_of_a_stopped_arm(robot: tool0.Robot) -> None:
    robot.arm.control_box.stop_protectively("a test")
    with pytest.raises(ControlError, match="protective stop"):
        robot.switch(start=[ARM])
    with pytest.raises(ControlError, match="protective stop"):
        robot.move_joints(ELBOW)
    with pytest.raises(GoalRejectedError, match=r"protective stop.*unlock"):
        robot.controller(ARM).move(ELBOW)
    with pytest.raises(ControlError, match="protective stop"):
        robot.arm.move_to(robot.arm.pose())
    status = next(s for s in robot.snapshot.controllers if s.name == ARM)
    assert "a test" in status.blocked
    assert robot.gripper.move(opening=0.02).wait(5.0)


@pytest.mark.slow
def test_a_protective_stop_holds_until_it_is_unlocked_and_played(
    robot: tool0.Robot,
) -> None:
    box, before = robot.arm.control_box, running(robot)
    with pytest.raises(ControlError, match="not in a protective stop"):
        box.unlock()
    goal, *_ = robot.move_joints(ELBOW)
    robot.run(0.3)
    box.stop_protectively("somebody is near")
    box.stop_protectively("a later reason")
    state = box.state
    assert state.robot_mode is RobotMode.RUNNING
    assert state.safety_mode is SafetyMode.PROTECTIVE_STOP
    assert state.protective_stop == "somebody is near"
    assert goal.status.is_terminal
    robot.run(0.5)
    held = robot.arm.joints["elbow_joint"]
    with pytest.raises(ControlError, match="Cannot unlock protective stop until 5s"):
        box.unlock()
    with pytest.raises(ControlError, match="protective stop"):
        box.play()
    robot.run(4.6)
    box.unlock()
    assert box.state.safety_mode is SafetyMode.NORMAL
    assert box.state.protective_stop == ""
    robot.run(0.5)
    assert robot.arm.joints["elbow_joint"] == pytest.approx(held, abs=1e-3)
    box.play()
    assert running(robot) == before
    assert robot.move_joints(ELBOW)[0].wait(5.0)


def test_a_reset_lets_a_protective_stop_be_unlocked(robot: tool0.Robot) -> None:
    robot.run(1.0)
    box = robot.arm.control_box
    box.stop_protectively("a test")
    robot.reset()
    assert box.state.safety_mode is SafetyMode.PROTECTIVE_STOP
    box.unlock()
    assert box.state.safety_mode is SafetyMode.NORMAL


def test_restarting_the_safety_leaves_the_arm_off(robot: tool0.Robot) -> None:
    box = robot.arm.control_box
    box.stop_protectively("a test")
    box.restart_safety()
    assert box.state.safety_mode is SafetyMode.NORMAL
    assert box.state.robot_mode is RobotMode.POWER_OFF
    assert box.state.protective_stop == ""


def test_the_emergency_stop_hides_the_modes(robot: tool0.Robot) -> None:
    box = robot.arm.control_box
    box.stop_protectively("a test")
    stopped = box.state
    robot.emergency_stop()
    assert box.state.safety_mode is SafetyMode.ROBOT_EMERGENCY_STOP
    assert box.state.robot_mode is RobotMode.POWER_OFF
    for refused in (box.power_on, box.release_brakes, box.restart_safety):
        with pytest.raises(ControlError, match="emergency stop"):
            refused()
    robot.emergency_stop(False)
    assert box.state == stopped
    robot.emergency_stop()
    box.power_off()
    robot.emergency_stop(False)
    assert box.state.robot_mode is RobotMode.POWER_OFF


@pytest.mark.slow
def test_only_one_arm_of_a_cell_stops() -> None:
    cell = DescriptionConfig(robots=("left=ur5e+2f85", "right=ur3e+hande@1,0,0"))
    with tool0.bringup(description=cell, realtime=False) as robot:
        before = running(robot)
        elbows = {f"{name}_elbow_joint": 1.0 for name in ("left", "right")}
        goals = robot.move_joints(elbows)
        robot.run(0.2)
        left = robot.arms["left"]
        left.control_box.stop_protectively("a test")
        assert {goal.status.is_terminal for goal in goals} == {True, False}
        assert all(name.startswith("left") for name in before - running(robot))
        robot.run(5.1)
        assert robot.arms["right"].joints["right_elbow_joint"] == pytest.approx(
            1.0, abs=0.01
        )
        assert abs(left.joints["left_elbow_joint"] - 1.0) > 0.1
        left.control_box.unlock()
        left.control_box.play()
        assert running(robot) == before


def test_a_taken_arm_is_released(robot: tool0.Robot) -> None:
    box, before = robot.arm.control_box, running(robot)
    simulation = robot.simulation
    arm, core = simulation.core.arms.find(None), simulation.core

    def take(by: str) -> None:
        simulation.loop.call(lambda: arm.take(by, core.state))

    def release() -> None:
        simulation.loop.call(lambda: arm.release(core.state))

    take("a program")
    take("another")
    assert box.state.taken_by == "another"
    assert box.state.program is ProgramState.PLAYING
    assert not box.state.is_program_running
    assert ARM not in running(robot)
    with pytest.raises(ControlError, match="'another' moves the arm"):
        robot.switch(start=[ARM])
    release()
    release()
    assert box.state.is_program_running
    assert running(robot) == before
    take("a program")
    box.stop()
    assert box.state.taken_by == ""
    assert box.state.program is ProgramState.STOPPED
    box.play()
    assert running(robot) == before
    box.pause()
    take("a program")
    release()
    assert box.state.program is ProgramState.STOPPED
