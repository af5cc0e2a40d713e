"""Cells: two robots in one world, each on its own, one emergency stop for all."""

from __future__ import annotations

import numpy as np
import pytest
from conformance_types import BringUp
from ur5_rig import worst_departure

import tool0
from tool0.description.parts import joints_of

TWINS = ("left=ur5+2f85@0,0.45,0", "right=ur5@0,-0.45,0,0,0,90deg")
CLOSE = 0.02  # [rad]
ARRIVAL = 1.0
"""Time after the last point within which a goal succeeds, the default [s]."""


@pytest.fixture
def cell(bring_up: BringUp) -> tool0.Robot:
    return bring_up(robots=TWINS)


def test_every_robot_holds(cell: tool0.Robot) -> None:
    assert worst_departure(cell, 5.0) <= CLOSE
    assert cell.info.warnings == ()


def test_robots_of_different_families_hold_and_grip(bring_up: BringUp) -> None:
    mixed = ("a=ur3e+hande@0,0.6,0", "b=ur10e+2f140@0,-0.6,0", "c=ur5@1.6,0,0")
    robot = bring_up(robots=mixed)
    assert worst_departure(robot, 3.0) <= CLOSE
    goals = {
        name: gripper.move(opening=gripper.geometry.max_opening / 2.0)
        for name, gripper in robot.grippers.items()
    }
    for name, goal in goals.items():
        assert goal.wait(5.0).status is tool0.GoalStatus.SUCCEEDED
        half = robot.grippers[name].geometry.max_opening / 2.0
        assert robot.grippers[name].opening == pytest.approx(half, abs=2e-3)
    assert robot.summary()["max_drift"] <= CLOSE


def test_both_move_at_once_to_their_own_goals(cell: tool0.Robot) -> None:
    targets = {
        "left_shoulder_pan_joint": 0.4,
        "left_elbow_joint": 1.2,
        "right_shoulder_pan_joint": -0.5,
        "right_wrist_1_joint": -1.0,
    }
    goals = cell.move_joints(targets)
    assert {goal.controller for goal in goals} == {
        "left_eff_joint_traj_controller",
        "right_eff_joint_traj_controller",
    }
    started = cell.time
    for goal in goals:
        assert goal.wait(10.0).status is tool0.GoalStatus.SUCCEEDED
    assert cell.time - started < 3.0  # one after the other takes twice as long
    cell.run(0.5)
    position = cell.joint_state.position
    for joint, target in targets.items():
        assert position[joint] == pytest.approx(target, abs=5e-3)


def test_both_arrive_after_the_same_time_or_none_moves(cell: tool0.Robot) -> None:
    targets = {"left_elbow_joint": 1.2, "right_elbow_joint": 1.3}
    begin = cell.time
    goals = cell.move_joints(targets, duration=1.0)
    assert len(goals) == 2
    for goal in goals:
        assert goal.wait(5.0).status is tool0.GoalStatus.SUCCEEDED
    assert cell.time - begin < 1.0 + ARRIVAL
    for joint, target in targets.items():
        assert cell.joint_state.position[joint] == pytest.approx(target, abs=CLOSE)

    desired = cell.joint_state.position["left_elbow_joint"]
    too_far = {"left_elbow_joint": 1.0, "right_elbow_joint": -1.5}
    with pytest.raises(tool0.Tool0Error, match="'right_elbow_joint' needs"):
        cell.move_joints(too_far, duration=0.2, collision="ignore")
    cell.run(0.3)
    held = cell.joint_state.position["left_elbow_joint"]
    assert held == pytest.approx(desired, abs=1e-3)


def test_a_gripper_moves_alone(cell: tool0.Robot) -> None:
    right = joints_of(cell.description.model, "right")
    cell.run(0.5)
    before = cell.joint_state.position
    assert (
        cell.grippers["left"].move(opening=0.03).wait(5.0).status
        is tool0.GoalStatus.SUCCEEDED
    )
    cell.run(0.2)
    assert cell.grippers["left"].opening == pytest.approx(0.03, abs=1e-3)
    after = cell.joint_state.position
    assert max(abs(after[name] - before[name]) for name in right) < 1e-2


def test_the_emergency_stop_holds_all_robots(cell: tool0.Robot) -> None:
    goals = cell.move_joints(
        {"left_shoulder_pan_joint": 1.0, "right_shoulder_pan_joint": 1.0}
    )
    cell.run(0.4)
    assert all(
        abs(cell.joint_state.velocity[f"{side}_shoulder_pan_joint"]) > 0.1
        for side in ("left", "right")
    )
    cell.emergency_stop()
    cell.run(1.0)
    assert [goal.status for goal in goals] == [tool0.GoalStatus.PREEMPTED] * 2
    assert np.abs(list(cell.joint_state.velocity.values())).max() < 1e-2
    stopped = dict(cell.joint_state.position)
    cell.run(2.0)
    now = cell.joint_state.position
    assert max(abs(now[name] - stopped[name]) for name in now) < 5e-3


def test_the_force_sensor_of_each_arm_weighs_its_own_tool(cell: tool0.Robot) -> None:
    cell.run(1.0)
    wrenches = {}
    for name, arm in cell.arms.items():
        sensor = arm.force_torque
        sensor.start(rate=125)
        cell.run(0.5)
        wrenches[name] = np.linalg.norm(sensor.read().force)
    assert wrenches["left"] == pytest.approx(0.9 * 9.81, abs=1.0)  # a 2F-85: 0.9 kg
    assert wrenches["right"] == pytest.approx(0.0, abs=0.1)
