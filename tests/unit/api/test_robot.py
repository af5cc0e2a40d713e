"""The facade: what a person holds."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import FrozenInstanceError
from pathlib import Path

import pytest

import tool0
from tool0.description.transform import Transform
from tool0.errors import (
    ClaimError,
    ConfigError,
    ControlError,
    GoalTimeoutError,
    ModelError,
    RequestError,
)

ARM = "eff_joint_traj_controller"
HOME = [0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0]
SUMMARY_KEYS = {
    "engine",
    "sim_time",
    "wall_time",
    "real_time_factor",
    "steps",
    "overruns",
    "controllers",
    "joints",
    "max_drift",
    "warnings",
}


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False) as robot:
        yield robot


def point(positions: list[float], time: float) -> tool0.TrajectoryPoint:
    return tool0.TrajectoryPoint(positions=positions, time_from_start=time)


def states(robot: tool0.Robot) -> dict[str, str]:
    return {status.name: status.state for status in robot.controllers()}


def test_it_comes_up_with_the_controllers_of_the_launch_file(
    robot: tool0.Robot,
) -> None:
    assert states(robot) == {
        "joint_state_controller": "running",
        "eff_joint_traj_controller": "running",
        "gripper_controller": "running",
        "joint_group_eff_controller": "initialized",
    }
    assert robot.time == 0.0
    assert robot.warnings == ()


def test_joint_states_are_by_name_with_mimic_joints(robot: tool0.Robot) -> None:
    state = robot.joint_state
    assert [*state.position.values()][:6] == HOME
    assert len(state.position) == len(state.velocity) == len(state.effort) == 12
    assert "left_inner_knuckle_joint" in state.position
    with pytest.raises(FrozenInstanceError):
        state.time = 1.0  # type: ignore[misc]


def test_poses_are_those_of_the_kinematics(robot: tool0.Robot) -> None:
    T_base_tool0 = robot.pose("tool0", relative_to="base")
    T_tool0_base = robot.pose("base", relative_to="tool0")
    unit = T_base_tool0 @ T_tool0_base
    assert unit.position == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    assert robot.pose("world") == Transform()
    with pytest.raises(ModelError, match=r"'tol0'.*'tool0'"):
        robot.pose("tol0")


def test_controllers_are_loaded_switched_and_unloaded_without_time_passing(
    robot: tool0.Robot,
) -> None:
    robot.unload("joint_group_eff_controller")
    assert "joint_group_eff_controller" not in states(robot)
    robot.load("joint_group_eff_controller")
    assert states(robot)["joint_group_eff_controller"] == "initialized"
    with pytest.raises(ClaimError):
        robot.switch(start=["joint_group_eff_controller"])
    robot.switch(start=["joint_group_eff_controller"], stop=[ARM])
    assert states(robot)[ARM] == "stopped"
    assert states(robot)["joint_group_eff_controller"] == "running"
    assert robot.time == 0.0


def test_best_effort_skips_what_strict_refuses(robot: tool0.Robot) -> None:
    with pytest.raises(ControlError):
        robot.switch(start=["nobody"], stop=["gripper_controller"])
    assert states(robot)["gripper_controller"] == "running"
    robot.switch(start=["nobody"], stop=["gripper_controller"], strict=False)
    assert states(robot)["gripper_controller"] == "stopped"


def test_an_unknown_controller_is_refused_with_the_nearest(robot: tool0.Robot) -> None:
    with pytest.raises(ControlError, match=f"{ARM}"):
        robot.controller("eff_joint_trj_controller")


@pytest.mark.parametrize("duration", [-1.0, math.nan])
def test_time_runs_forwards_only(robot: tool0.Robot, duration: float) -> None:
    with pytest.raises(RequestError, match="duration"):
        robot.run(duration)


def test_a_wait_passes_time_until_the_goal_ends(robot: tool0.Robot) -> None:
    goal = robot.controller(ARM).follow([point([0.1, *HOME[1:]], 0.5)])
    assert repr(goal) == f"GoalHandle('{ARM}', ACTIVE)"
    result = goal.wait(timeout=5.0)
    assert str(result) == (
        "GoalResult(status=SUCCEEDED, error_code=0, error_string='')"
    )
    assert 0.5 <= robot.time < 0.7
    assert goal.result is result
    at = robot.time
    assert goal.wait() is result
    assert robot.time == at


def test_a_wait_that_is_too_short_says_so_and_the_goal_goes_on(
    robot: tool0.Robot,
) -> None:
    goal = robot.controller(ARM).follow([point([0.1, *HOME[1:]], 1.0)])
    with pytest.raises(GoalTimeoutError, match=r"0\.25") as caught:
        goal.wait(timeout=0.25)
    assert isinstance(caught.value, TimeoutError)
    assert robot.time == pytest.approx(0.25)
    assert goal.status is tool0.GoalStatus.ACTIVE
    goal.wait(timeout=5.0)
    assert goal.status is tool0.GoalStatus.SUCCEEDED


def test_a_wait_in_real_time_is_of_wall_time() -> None:
    with tool0.bringup(realtime=True, speed=50.0) as robot:
        goal = robot.controller(ARM).follow([point([0.1, *HOME[1:]], 0.5)])
        assert goal.wait(timeout=30.0).status is tool0.GoalStatus.SUCCEEDED
        goal = robot.controller(ARM).follow([point(HOME, 1000.0)])
        with pytest.raises(GoalTimeoutError):
            goal.wait(timeout=0.01)
        assert robot.time < 900.0


def test_what_is_wanted_and_had_can_be_asked(robot: tool0.Robot) -> None:
    arm = robot.controller(ARM)
    arm.follow([point([0.4, *HOME[1:]], 1.0)])
    robot.run(0.5)
    assert arm.query_state(0.5).positions[0] == pytest.approx(0.2)
    assert arm.query_state(9.0).positions[0] == pytest.approx(0.4)
    state = arm.state
    assert state.joint_names[0] == "shoulder_pan_joint"
    assert state.error.positions[0] == pytest.approx(
        state.desired.positions[0] - state.actual.positions[0]
    )


def test_pausing_stepping_and_resuming(robot: tool0.Robot) -> None:
    robot.pause()
    with pytest.raises(ControlError, match="paused"):
        robot.run(1.0)
    robot.step()
    robot.step(9)
    assert robot.time == pytest.approx(0.010)
    assert robot.joint_state.time == robot.time
    robot.resume()
    robot.run(0.010)
    assert robot.time == pytest.approx(0.020)


def test_it_may_begin_paused() -> None:
    with tool0.bringup(realtime=True, paused=True) as robot:
        assert robot.snapshot.is_paused
        robot.step(3)
        assert robot.time == pytest.approx(0.003)


def test_a_reset_brings_time_and_pose_back(robot: tool0.Robot) -> None:
    robot.controller(ARM).follow([point([0.5, *HOME[1:]], 0.5)]).wait(5.0)
    robot.gripper.move(opening=0.04).wait(5.0)
    robot.reset()
    assert robot.time == robot.joint_state.time == 0.0
    assert [*robot.joint_state.position.values()][:7] == [*HOME, 0.0]
    assert states(robot)[ARM] == "running"
    robot.reset({"finger_joint": 0.4})
    position = robot.joint_state.position
    assert position["finger_joint"] == 0.4
    assert position["left_inner_finger_joint"] == -0.4


def test_the_summary_has_the_keys_that_were_promised(robot: tool0.Robot) -> None:
    robot.run(0.5)
    summary = json.loads(json.dumps(robot.summary(), allow_nan=False))
    assert summary.keys() == SUMMARY_KEYS
    assert summary["engine"] == "mujoco"
    assert (summary["sim_time"], summary["steps"]) == (0.5, 500)
    assert summary["real_time_factor"] == pytest.approx(0.5 / summary["wall_time"])
    assert all(
        item.keys() == {"name", "type", "state", "claimed"}
        for item in summary["controllers"]
    )
    arm = next(item for item in summary["controllers"] if item["name"] == ARM)
    assert arm["claimed"][0] == "shoulder_pan_joint"
    assert len(summary["joints"]) == 12
    assert summary["joints"]["elbow_joint"].keys() == {
        "position",
        "velocity",
        "effort",
    }
    assert 0.0 < summary["max_drift"] < 0.02  # the droop of the effort controller
    assert summary["overruns"] == 0


def test_the_summary_tells_where_the_yaml_says_what_nothing_reads() -> None:
    files = [
        Path("tests/data/controllers") / name
        for name in ("ur5_controllers.yaml", "gazebo_controller.yaml")
    ]
    with tool0.bringup(realtime=False, controllers_file=files) as robot:
        warnings = robot.summary()["warnings"]
    assert isinstance(warnings, list)
    assert all(w.keys() == {"file", "line", "key", "message"} for w in warnings)
    told = {(Path(w["file"]).name, w["line"]): w["message"] for w in warnings}
    lines = files[0].read_text().splitlines()
    useless = 1 + next(i for i, line in enumerate(lines) if "goal_tolerance" in line)
    assert "GripperActionController" in told["ur5_controllers.yaml", useless]
    assert any(
        "gazebo_ros_control/pid_gains" in message
        for (file, _), message in told.items()
        if file == "gazebo_controller.yaml"
    )


def test_a_robot_without_a_gripper_says_so() -> None:
    with tool0.bringup(realtime=False, gripper=None) as robot:
        assert robot.grippers == {}
        with pytest.raises(ControlError):
            _ = robot.gripper
        robot.run(0.01)


def test_a_prefix_reaches_joints_controllers_and_gripper() -> None:
    with tool0.bringup(realtime=False, prefix="left_") as robot:
        goal = robot.controller(ARM).follow([point([0.2, *HOME[1:]], 0.5)])
        assert goal.wait(5.0).error_code == 0
        assert robot.gripper.move(opening=0.04).wait(5.0).error_code == 0
        assert robot.joint_state.position["left_elbow_joint"] == pytest.approx(
            1.5708, abs=0.02
        )


def test_a_pose_may_be_named_or_given_by_joints() -> None:
    with tool0.bringup(realtime=False, initial_pose="half") as robot:
        assert robot.gripper.opening == pytest.approx(0.0425, abs=1e-4)
    given = {"elbow_joint": 1.0, "finger_joint": 0.2}
    with tool0.bringup(realtime=False, initial_pose=given) as robot:
        position = robot.joint_state.position
        assert (position["elbow_joint"], position["finger_joint"]) == (1.0, 0.2)
        assert position["shoulder_lift_joint"] == -1.5708  # as at home
    with pytest.raises(ConfigError, match=r"'hme'.*'home'"):
        tool0.bringup(realtime=False, initial_pose="hme")


def test_closing_twice_is_allowed_and_state_stays_readable(robot: tool0.Robot) -> None:
    robot.run(0.1)
    robot.close()
    robot.close()
    assert robot.time == pytest.approx(0.1)
    assert robot.joint_state.time == pytest.approx(0.1)
    with pytest.raises(ControlError, match="closed"):
        robot.reset()
