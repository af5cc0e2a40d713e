"""Named poses of a robot, by the facade."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from tool0.runtime.saved_poses import poses_file
from ur5_rig import ARM, ARM_JOINTS, POST, POST_GRIPPER

import tool0
from tool0.errors import ConfigError, ControlError

PAN = ARM_JOINTS[0]


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False) as robot:
        yield robot


def test_the_robot_s_own_poses_come_first(robot: tool0.Robot) -> None:
    own = list(robot.poses())
    assert {"home", "ready", "zero"} <= set(own)
    assert not any(pose.saved for pose in robot.poses().values())
    robot.save_pose("a")
    assert list(robot.poses()) == [*own, "a"]
    assert robot.poses()["a"].saved


def test_a_saved_pose_is_where_the_driven_joints_are(robot: tool0.Robot) -> None:
    robot.move_joints({PAN: 0.5, "finger_joint": 0.3}, speed=1.0)
    robot.run(3.0)
    robot.save_pose("here")
    saved = robot.poses()["here"].positions
    assert list(saved) == [*ARM_JOINTS, "finger_joint"]
    assert saved[PAN] == pytest.approx(0.5, abs=1e-3)
    assert saved["finger_joint"] == pytest.approx(0.3, abs=1e-3)


def test_one_goes_to_a_saved_pose_and_the_next_run_may_start_there(
    robot: tool0.Robot,
) -> None:
    robot.move_joints({PAN: 0.5, "finger_joint": 0.3}, speed=1.0)
    robot.run(3.0)
    robot.save_pose("here")
    for goal in robot.go_to_pose("home", speed=1.0):
        assert goal.wait(5.0).status is tool0.GoalStatus.SUCCEEDED
    assert abs(robot.joint_state.position[PAN]) < 0.01
    arm, gripper = robot.go_to_pose("here")
    assert arm.wait(5.0).status is gripper.wait(5.0).status
    robot.run(1.0)
    assert robot.joint_state.position[PAN] == pytest.approx(0.5, abs=1e-3)
    with tool0.bringup(realtime=False, initial_pose="here") as next_one:
        assert next_one.joint_state.position[PAN] == pytest.approx(0.5, abs=1e-3)


def test_a_pose_at_a_limit_can_be_gone_to_again(robot: tool0.Robot) -> None:
    robot.gripper.move(opening=0.0)
    robot.run(2.0)
    robot.save_pose("closed tight")
    robot.go_to_pose("open")
    robot.run(2.0)
    robot.go_to_pose("closed tight")


def test_a_pose_that_no_controller_can_reach_is_refused() -> None:
    files = [POST, POST_GRIPPER]
    with tool0.bringup(realtime=False, controllers_file=files) as robot:
        robot.save_pose("here")
        with pytest.raises(ControlError, match="claims joint 'finger_joint'"):
            robot.go_to_pose("here")
        assert robot.controller(ARM).state.desired.velocities == (0.0,) * 6


def test_the_robot_s_own_poses_stay(robot: tool0.Robot) -> None:
    with pytest.raises(ControlError, match="'home' came with the robot; choose"):
        robot.save_pose("home")
    with pytest.raises(ControlError, match="'home' came with the robot; only"):
        robot.delete_pose("home")


def test_a_saved_pose_can_be_replaced_and_deleted(robot: tool0.Robot) -> None:
    robot.save_pose("a")
    robot.move_joints({PAN: 0.5}, speed=1.0)
    robot.run(2.0)
    robot.save_pose("a")
    assert robot.poses()["a"].positions[PAN] == pytest.approx(0.5, abs=1e-3)
    robot.delete_pose("a")
    assert "a" not in robot.poses()
    with pytest.raises(ControlError, match="unknown pose 'a'"):
        robot.delete_pose("a")


def test_unknown_poses_are_told_with_the_nearest(robot: tool0.Robot) -> None:
    with pytest.raises(ControlError, match="did you mean 'home'"):
        robot.go_to_pose("hom")
    with pytest.raises(ConfigError, match="did you mean 'home'"):
        tool0.bringup(realtime=False, initial_pose="hom")


@pytest.mark.parametrize("name", ["", " ", "a ", "a\nb", "a\x00", "x" * 61, "\u200b"])
def test_names_that_nobody_could_read_are_refused(robot: tool0.Robot, name) -> None:
    with pytest.raises(ControlError, match="a pose cannot be called"):
        robot.save_pose(name)
    robot.save_pose("x" * 60)


def test_a_broken_file_hides_none_of_the_robot_s_own_poses(robot: tool0.Robot) -> None:
    file = poses_file(robot.description.model.name)
    file.parent.mkdir(parents=True)
    file.write_text("a: [")
    with pytest.raises(ConfigError, match=r"\.yaml:1: not YAML"):
        robot.poses()
    robot.go_to_pose("home")
    with tool0.bringup(realtime=False, initial_pose="ready"):
        pass


def test_a_saved_pose_called_like_one_of_the_robot_s_is_hidden(
    robot: tool0.Robot,
) -> None:
    file = poses_file(robot.description.model.name)
    file.parent.mkdir(parents=True)
    file.write_text(f"home: {{{PAN}: 1.0}}\n")
    assert not robot.poses()["home"].saved


def test_it_tells_every_controller_that_the_yaml_defines(robot: tool0.Robot) -> None:
    assert dict(robot.defined_controllers) == {
        "joint_state_controller": "joint_state_controller/JointStateController",
        "eff_joint_traj_controller": "effort_controllers/JointTrajectoryController",
        "gripper_controller": "effort_controllers/JointTrajectoryController",
        "joint_group_eff_controller": "effort_controllers/JointGroupEffortController",
    }
    assert next(iter(robot.defined_controllers)) == "joint_state_controller"
    assert (robot.control_period, robot.is_realtime) == (0.001, False)
