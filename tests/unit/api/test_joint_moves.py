from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from raises_naming import raises_naming
from ur5_rig import ARM, ARM_JOINTS, GRIPPER, POST, POST_GRIPPER

import tool0
from tool0.description.model import TIME_TO_FULL_SPEED
from tool0.errors import ControlError, GoalRejectedError, RequestError

DT = 0.001  # [s], a tick
PAN, LIFT, ELBOW = ARM_JOINTS[:3]
FINGER = "finger_joint"


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False) as robot:
        yield robot


def desired(robot: tool0.Robot, controller: str = ARM) -> dict[str, float]:
    state = robot.controller(controller).state
    return dict(zip(state.joint_names, state.desired.positions, strict=True))


def test_joints_of_several_controllers_move_at_once(robot: tool0.Robot) -> None:
    goals = robot.move_joints({FINGER: 0.4, PAN: 0.5, ELBOW: 1.2}, speed=1.0)
    assert [goal.controller for goal in goals] == [GRIPPER, ARM]
    assert all(goal.wait(5.0).status is tool0.GoalStatus.SUCCEEDED for goal in goals)
    robot.run(0.5)
    position = robot.joint_state.position
    assert position[FINGER] == pytest.approx(0.4, abs=1e-3)
    assert position[PAN] == pytest.approx(0.5, abs=1e-3)
    assert position[ELBOW] == pytest.approx(1.2, abs=0.02)  # its PID sags that much


def test_what_is_not_named_stays_or_goes_on(robot: tool0.Robot) -> None:
    arm = robot.controller(ARM)
    before = desired(robot)
    arm.move({PAN: 1.0})
    robot.run(0.2)
    arm.move({LIFT: -1.0}).wait(10.0)
    assert desired(robot) == pytest.approx({**before, PAN: 1.0, LIFT: -1.0})


@pytest.mark.slow
def test_a_stream_of_new_targets_is_followed_smoothly(robot: tool0.Robot) -> None:
    rng = np.random.default_rng(8)
    robot.run(1.0)  # the arm sags into its PIDs at first
    arm = robot.controller(ARM)
    limits = [robot.description.model.joint(name).limits for name in ARM_JOINTS]
    most = np.array([item.velocity for item in limits]) / TIME_TO_FULL_SPEED
    target = np.array(arm.state.desired.positions)
    wanted, measured = [], []
    for _ in range(25):
        target = np.clip(target + rng.uniform(-0.4, 0.4, 6), -2.0, 2.0)
        target[1] = np.clip(target[1], -2.0, -0.8)  # off the ground
        arm.steer(
            dict(zip(ARM_JOINTS, target, strict=True)), speed=rng.choice([0.2, 1])
        )
        for _ in range(100):
            robot.run(DT)
            wanted.append(arm.state.desired)
            measured.append(arm.state.actual.velocities)
    velocity = np.array([motion.velocities for motion in wanted])
    position = np.array([motion.positions for motion in wanted])
    assert (abs(np.diff(velocity, axis=0)) <= 1.1 * most * DT).all()
    np.testing.assert_allclose(np.diff(position, axis=0) / DT, velocity[1:], atol=0.02)
    assert abs(velocity).max() > 0.5, "it moved"
    jumps = abs(np.diff(measured, axis=0))
    assert (jumps <= 2.0 * most * DT).all(), "the joints follow without jerks"
    robot.run(5.0)
    np.testing.assert_allclose(arm.state.desired.positions, target, atol=1e-9)
    np.testing.assert_allclose(arm.state.actual.positions, target, atol=0.02)


def test_a_target_out_of_limits_is_refused_and_nothing_moves(
    robot: tool0.Robot,
) -> None:
    before = robot.controller(ARM).state.desired, robot.controller(GRIPPER).state
    for bad in (7.0, math.nan, math.inf):
        kind = GoalRejectedError if math.isfinite(bad) else RequestError
        with pytest.raises(kind):
            robot.controller(ARM).steer({LIFT: -1.0, PAN: bad})
        with pytest.raises(kind):
            robot.move_joints({FINGER: 0.4, PAN: bad})
    robot.run(0.1)
    after = robot.controller(ARM).state.desired, robot.controller(GRIPPER).state
    assert before[0].positions == after[0].positions
    assert before[1].desired.positions == after[1].desired.positions


def test_a_joint_that_no_trajectory_controller_claims_stops_all() -> None:
    with tool0.bringup(realtime=False, controllers_file=[POST, POST_GRIPPER]) as robot:
        before = desired(robot)
        for bad in (FINGER, "elbow"):
            with raises_naming(ControlError, f"'{bad}'"):
                robot.move_joints({PAN: 1.0, bad: 0.4})
        robot.switch(stop=[ARM])
        with raises_naming(ControlError, PAN):
            robot.move_joints({PAN: 1.0})
        robot.switch(start=[ARM])
        robot.run(0.1)
        assert desired(robot) == pytest.approx(before, abs=0.01)


def test_a_joint_of_another_controller_is_refused(robot: tool0.Robot) -> None:
    with raises_naming(GoalRejectedError, "'elbow_joint'") as error:
        robot.controller(ARM).move({"elbow": 0.0})
    assert error.value.code == GoalRejectedError.INVALID_JOINTS
    with pytest.raises(ControlError):
        robot.controller("joint_state_controller").steer({PAN: 0.0})


def test_nothing_moves_under_the_emergency_stop(robot: tool0.Robot) -> None:
    robot.emergency_stop()
    with pytest.raises(ControlError):
        robot.move_joints({PAN: 0.0})
    with pytest.raises(ControlError):
        robot.controller(ARM).steer({PAN: 0.0})
    robot.emergency_stop(engaged=False)
    robot.move_joints({PAN: 0.0})


def test_a_goal_calls_back_when_it_ends_and_after(robot: tool0.Robot) -> None:
    heard: list[tool0.GoalHandle] = []
    goal = robot.controller(ARM).move({PAN: 0.1})
    goal.when_finished(heard.append)
    assert not heard
    goal.wait(5.0)
    assert heard == [goal]
    goal.when_finished(heard.append)
    assert heard == [goal, goal]


def test_steering_replaces_a_goal_and_is_the_same_to_the_bit_in_every_run() -> None:
    ends = []
    for _ in range(2):
        with tool0.bringup(realtime=False) as robot:
            goal = robot.controller(ARM).move({PAN: 1.0})
            for angle in (0.2, -0.3, 0.6):
                robot.controller(ARM).steer({PAN: angle, ELBOW: 1.0 + angle})
                robot.run(0.1)
            assert goal.status is tool0.GoalStatus.PREEMPTED
            ends.append(robot.joint_state)
    assert ends[0] == ends[1]
