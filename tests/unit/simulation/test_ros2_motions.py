"""ROS 2's own controllers on the robot in MuJoCo."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import tool0
from tool0 import GoalStatus, TrajectoryPoint
from tool0.control.trajectory_monitor import REACHED
from tool0.protocol.goals import GoalResult

CONTROLLER = "joint_trajectory_controller"


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    description = tool0.DescriptionConfig(ros2_control=True)
    with tool0.bringup(realtime=False, description=description) as robot:
        yield robot


@pytest.fixture(autouse=True)
def _home(robot: tool0.Robot) -> None:
    robot.reset()


def shifted(robot: tool0.Robot, by: float, time: float) -> TrajectoryPoint:
    """Return a point at rest, all joints of the arm beside where they are."""
    joints = robot.snapshot.controller_setpoints[CONTROLLER].state().desired
    there = [q + by for q in joints.positions]
    return TrajectoryPoint(there, [0.0] * len(there), time_from_start=time)


def test_a_goal_is_reached_when_its_end_is_commanded(robot: tool0.Robot) -> None:
    goal = robot.controller(CONTROLLER).follow([shifted(robot, 0.3, 1.0)])
    robot.run(0.99)
    assert goal.status is GoalStatus.ACTIVE
    robot.run(0.01)
    assert goal.result == REACHED
    state = robot.snapshot.controller_setpoints[CONTROLLER].state()
    assert max(map(abs, state.error.positions)) < 0.01


def test_a_goal_that_is_too_fast_violates_the_path_and_the_arm_stops(
    robot: tool0.Robot,
) -> None:
    goal = robot.controller(CONTROLLER).follow([shifted(robot, 2.0, 0.1)])
    robot.run(1.0)
    assert isinstance(goal.result, GoalResult)
    assert goal.result.error_code == GoalResult.PATH_TOLERANCE_VIOLATED
    assert goal.result.error_string.startswith(
        "Aborted due to path tolerance violation"
    )
    assert max(map(abs, robot.snapshot.velocity)) < 0.01


def test_the_speed_slider_slows_goals_down(robot: tool0.Robot) -> None:
    box = robot.arm.control_box
    box.set_speed_slider(0.5)
    robot.run(2.0)  # it changes smoothly
    try:
        goal = robot.controller(CONTROLLER).follow([shifted(robot, 0.2, 0.5)])
        robot.run(0.98)
        assert goal.status is GoalStatus.ACTIVE
        robot.run(0.04)
        assert goal.result == REACHED
    finally:
        box.set_speed_slider(1.0)
        robot.run(2.0)


def test_the_simulator_s_own_motions_use_the_controller(robot: tool0.Robot) -> None:
    goals = robot.move_joints({"elbow_joint": 1.2})
    robot.run(0.3)
    moving = robot.snapshot.velocity
    replaced = robot.move_joints({"elbow_joint": 1.0})
    robot.run(0.001)
    changes = [abs(a - b) for a, b in zip(robot.snapshot.velocity, moving, strict=True)]
    assert max(changes) < 0.05  # it starts with the desired motion
    assert goals[0].status is GoalStatus.ABORTED
    assert replaced[0].wait(10.0).status is GoalStatus.SUCCEEDED


def test_only_ros_2_scales_the_speed_of_a_controller(robot: tool0.Robot) -> None:
    with pytest.raises(tool0.ControlError, match="speed slider"):
        robot.controller(CONTROLLER).scale_speed(0.5)
    with pytest.raises(tool0.ControlError, match="only trajectory controllers of ROS"):
        robot.controller("robotiq_gripper_controller").scale_speed(0.5)
