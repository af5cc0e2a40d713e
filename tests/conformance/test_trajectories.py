"""Trajectory goals on the real arm: how they end, and what the arm does then."""

from __future__ import annotations

import numpy as np
import pytest
from conformance_types import BringUp
from ur5_rig import ARM, ARM_JOINTS, AWAY, HOME, POST, point, positions, worst_departure

import tool0
from tool0.protocol.goals import GoalResult

SUCCEEDED, ABORTED, PREEMPTED, ACTIVE = (
    tool0.GoalStatus.SUCCEEDED,
    tool0.GoalStatus.ABORTED,
    tool0.GoalStatus.PREEMPTED,
    tool0.GoalStatus.ACTIVE,
)
AT_REST = [0.0] * 6
PLACED = 1e-5
"""How exactly an engine puts a joint [rad]: libsdformat writes six digits."""


def arm_positions(robot: tool0.Robot) -> np.ndarray:
    return positions(robot)[:6]


def partial_yaml(tmp_path: object) -> str:
    text = POST.read_text()
    path = f"{tmp_path}/partial.yaml"
    marked = "stop_trajectory_duration: 0.5"
    assert marked in text
    with open(path, "w") as file:  # noqa: PTH123
        file.write(text.replace(marked, f"{marked}\n  allow_partial_joints_goal: true"))
    return path


def test_a_trajectory_succeeds_where_it_was_sent(robot: tool0.Robot) -> None:
    way = [
        point(AWAY, 1.0, [0.1, 0.0, 0.0, 0.0, 0.0, 0.0]),
        point(HOME, 2.0, AT_REST),
        point(AWAY, 3.0, AT_REST),
    ]
    result = robot.controller(ARM).follow(way).wait(10.0)
    assert result == GoalResult(status=SUCCEEDED, error_code=0, error_string="")
    assert 3.0 <= robot.time <= 3.6  # within goal_time
    robot.run(1.0)
    assert arm_positions(robot) == pytest.approx(AWAY, abs=0.02)


def test_joints_may_come_in_any_order(robot: tool0.Robot) -> None:
    order = [3, 0, 5, 1, 4, 2]
    goal = robot.controller(ARM).follow(
        [point([AWAY[k] for k in order], 1.0)],
        joint_names=[ARM_JOINTS[k] for k in order],
    )
    assert goal.wait(5.0).status is SUCCEEDED
    robot.run(0.5)
    assert arm_positions(robot) == pytest.approx(AWAY, abs=0.02)


def test_an_arm_that_cannot_follow_is_aborted_at_once(robot: tool0.Robot) -> None:
    goal = robot.controller(ARM).follow([point((3.0, *HOME[1:]), 0.3)])
    result = goal.wait(5.0)
    assert (result.status, result.error_code) == (ABORTED, -4)
    assert result.error_string.startswith("shoulder_pan_joint path error 0.1")
    assert robot.time < 0.3
    robot.run(2.5)
    assert worst_departure(robot, 3.0) <= 1e-3


def test_a_tight_path_tolerance_of_the_goal_is_enforced(robot: tool0.Robot) -> None:
    arm = robot.controller(ARM)
    robot.run(1.0)
    goal = arm.follow([point(AWAY, 1.0)], path_tolerance={"elbow_joint": 0.001})
    result = goal.wait(5.0)
    assert (result.status, result.error_code) == (ABORTED, -4)
    assert result.error_string.startswith("elbow_joint path error")
    robot.run(1.0)
    assert arm_positions(robot)[0] < 0.4, "it does not go on to the goal"
    assert worst_departure(robot, 1.0) <= 1e-3
    goal = arm.follow([point(AWAY, 1.0)], path_tolerance={"wrist_3_joint": 0.5})
    assert goal.wait(5.0).status is SUCCEEDED


def test_a_path_tolerance_below_zero_switches_the_check_off(robot: tool0.Robot) -> None:
    off = dict.fromkeys(ARM_JOINTS, -1.0)
    goal = robot.controller(ARM).follow(
        [point((1.5, *HOME[1:]), 0.3)], path_tolerance=off, goal_time_tolerance=5.0
    )
    assert goal.wait(10.0).status is SUCCEEDED


def test_a_goal_that_is_never_reached_is_aborted_after_its_grace(
    bring_up: BringUp,
) -> None:
    robot = bring_up(controllers_file=POST)
    goal = robot.controller(ARM).follow(
        [point(HOME, 1.0)],
        goal_tolerance={"elbow_joint": 0.001},  # its gains droop by 9 mrad
        goal_time_tolerance=0.25,
    )
    result = goal.wait(5.0)
    assert (result.status, result.error_code) == (ABORTED, -5)
    assert result.error_string.startswith("elbow_joint goal error ")
    assert robot.time == pytest.approx(1.25, abs=0.005)
    assert worst_departure(robot, 2.0) < 0.02


def test_an_endless_grace_waits_on(bring_up: BringUp) -> None:
    robot = bring_up(controllers_file=POST)
    goal = robot.controller(ARM).follow(
        [point(HOME, 0.5)],
        goal_tolerance={"elbow_joint": 0.001},
        goal_time_tolerance=-1.0,
    )
    robot.run(5.0)
    assert goal.status is ACTIVE


def test_cancelling_ramps_down_as_ros_does(robot: tool0.Robot) -> None:
    arm = robot.controller(ARM)
    goal = arm.follow([point((2.0, *HOME[1:]), 2.0)])  # the pan at 1 rad/s
    robot.run(1.0)
    wanted = arm.query_state(robot.time).positions[0]
    goal.cancel()
    assert goal.status is PREEMPTED
    assert goal.wait() == GoalResult(status=PREEMPTED, error_code=0, error_string="")
    robot.run(2.0)
    # The ramp of ROS ends 5/8 of speed times stop_trajectory_duration further on.
    assert arm.query_state(robot.time).positions[0] == pytest.approx(
        wanted + 5.0 / 8.0 * 1.0 * 0.5, abs=1e-6
    )
    assert worst_departure(robot, 2.0) <= 1e-3
    goal.cancel()  # again, and too late: nothing happens


def test_following_nothing_stops_and_succeeds(robot: tool0.Robot) -> None:
    arm = robot.controller(ARM)
    goal = arm.follow([point((2.0, *HOME[1:]), 2.0)])
    robot.run(1.0)
    stop = arm.follow([])
    assert goal.status is PREEMPTED
    assert stop.wait(5.0).status is SUCCEEDED
    assert robot.time == pytest.approx(1.5, abs=0.01)
    robot.run(1.0)
    assert worst_departure(robot, 2.0) <= 1e-3


def test_a_new_goal_replaces_the_old_one_without_a_jump(robot: tool0.Robot) -> None:
    arm = robot.controller(ARM)
    first = arm.follow([point((1.0, *HOME[1:]), 1.0)])
    robot.run(0.5)
    wanted = arm.query_state(robot.time).positions
    second = arm.follow([point((-0.5, *HOME[1:]), 2.0, AT_REST)])
    assert (first.status, second.status) == (PREEMPTED, ACTIVE)
    assert arm.query_state(robot.time).positions == pytest.approx(wanted)
    assert second.wait(5.0).status is SUCCEEDED
    assert arm_positions(robot)[0] == pytest.approx(-0.5, abs=0.01)


def test_a_goal_of_the_future_lets_the_old_one_run_on(robot: tool0.Robot) -> None:
    arm = robot.controller(ARM)
    arm.follow([point((0.4, *HOME[1:]), 1.0)])
    robot.run(0.2)
    later = arm.follow([point(HOME, 1.0, AT_REST)], stamp=0.6)
    assert arm.query_state(0.5).positions[0] == pytest.approx(0.2, abs=PLACED)
    assert arm.query_state(0.6).positions[0] == pytest.approx(0.24, abs=PLACED)
    assert later.wait(5.0).status is SUCCEEDED
    assert robot.time >= 1.6


def test_points_of_the_past_are_left_out(robot: tool0.Robot) -> None:
    robot.run(1.0)
    way = [point(HOME, 0.5), point((0.3, *HOME[1:]), 1.5)]
    goal = robot.controller(ARM).follow(way, stamp=0.1)
    assert goal.wait(5.0).status is SUCCEEDED
    assert robot.time >= 1.6
    assert arm_positions(robot)[0] == pytest.approx(0.3, abs=0.01)


def test_partial_goals_move_the_named_joints_only_where_allowed(
    bring_up: BringUp, tmp_path: object
) -> None:
    strict = bring_up(controllers_file=POST)
    with pytest.raises(tool0.GoalRejectedError) as caught:
        strict.controller(ARM).follow([point([1.0], 1.0)], joint_names=["elbow_joint"])
    assert caught.value.code == tool0.GoalRejectedError.INVALID_JOINTS
    robot = bring_up(controllers_file=partial_yaml(tmp_path))
    robot.run(1.0)
    before = arm_positions(robot)
    goal = robot.controller(ARM).follow(
        [point([1.2, 0.3], 1.0)], joint_names=["elbow_joint", "shoulder_pan_joint"]
    )
    assert goal.wait(5.0).status is SUCCEEDED
    after = arm_positions(robot)
    assert after[[0, 2]] == pytest.approx([0.3, 1.2], abs=0.02)
    assert after[[1, 3, 4, 5]] == pytest.approx(before[[1, 3, 4, 5]], abs=0.01)


def test_a_command_without_an_outcome_moves_the_arm_and_preempts(
    robot: tool0.Robot,
) -> None:
    arm = robot.controller(ARM)
    goal = arm.follow([point((1.0, *HOME[1:]), 2.0)])
    arm.command_trajectory([point(AWAY, 1.0)])
    assert goal.status is PREEMPTED
    robot.run(2.0)
    assert arm_positions(robot) == pytest.approx(AWAY, abs=0.02)


def test_the_longest_way_round_is_taken_where_joints_range_over_two_turns(
    bring_up: BringUp,
) -> None:
    robot = bring_up(initial_pose={"wrist_3_joint": 3.0})
    goal = robot.controller(ARM).follow([point((*HOME[:5], -3.0), 4.0, AT_REST)])
    robot.run(2.0)
    assert arm_positions(robot)[5] == pytest.approx(0.0, abs=0.02)
    assert goal.wait(5.0).status is SUCCEEDED


def test_a_reset_preempts_and_everything_works_again(robot: tool0.Robot) -> None:
    arm = robot.controller(ARM)
    goals = [arm.follow([point(AWAY, 2.0)]), robot.gripper.move(opening=0.0)]
    robot.run(0.3)
    start = dict(zip(ARM_JOINTS, HOME, strict=True))
    robot.reset()
    assert [goal.status for goal in goals] == [PREEMPTED, PREEMPTED]
    assert robot.time == 0.0
    measured = robot.joint_state.position
    at_start = pytest.approx(start, abs=PLACED)
    assert {name: measured[name] for name in start} == at_start
    running = [c.name for c in robot.controllers() if c.state == "running"]
    assert len(running) == 3
    assert worst_departure(robot, 1.0) < 0.02
    assert arm.follow([point(AWAY, 1.0)]).wait(5.0).status is SUCCEEDED
    assert robot.gripper.move(opening=0.03).wait(5.0).status is SUCCEEDED
