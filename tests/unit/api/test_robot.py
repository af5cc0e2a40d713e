from __future__ import annotations

import copy
import json
import math
import pickle
from collections.abc import Callable, Iterator
from dataclasses import FrozenInstanceError
from pathlib import Path

import pytest
from raises_naming import raises_naming
from ur5_rig import ARM, CONTROLLERS, HOME, POST, point

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


def states(robot: tool0.Robot) -> dict[str, str]:
    return {status.name: status.state for status in robot.controllers()}


def test_it_comes_up_at_home_with_the_controllers_of_the_launch_file(
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
    state = robot.joint_state
    assert tuple(state.position.values())[:6] == HOME
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
    with raises_naming(ModelError, "'tool0'"):
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
    robot.switch(start=["nobody"], stop=["joint_group_eff_controller"], strict=False)
    assert states(robot)["joint_group_eff_controller"] == "stopped"
    with raises_naming(ControlError, ARM):
        robot.controller("eff_joint_trj_controller")
    assert robot.time == 0.0


@pytest.mark.parametrize("duration", [-1.0, math.nan])
def test_time_runs_forwards_only(robot: tool0.Robot, duration: float) -> None:
    with raises_naming(RequestError, "duration"):
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
    at_end = robot.controller(ARM).query_state(at).positions
    assert at_end == pytest.approx((0.1, *HOME[1:]))


def test_a_wait_that_is_too_short_says_so_and_the_goal_goes_on(
    robot: tool0.Robot,
) -> None:
    goal = robot.controller(ARM).follow([point([0.1, *HOME[1:]], 1.0)])
    with pytest.raises(TimeoutError) as caught:
        goal.wait(timeout=0.25)
    assert isinstance(caught.value, GoalTimeoutError)
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


@pytest.mark.parametrize("of", [lambda it: it, lambda it: it.gripper])
def test_a_robot_cannot_be_pickled(
    robot: tool0.Robot, of: Callable[[tool0.Robot], object]
) -> None:
    with pytest.raises(TypeError, match=r"call tool0\.connect\(name\) there"):
        pickle.dumps(of(robot))
    with pytest.raises(TypeError, match="cannot be pickled or copied"):
        copy.deepcopy(of(robot))


def test_pausing_stepping_and_resuming(robot: tool0.Robot) -> None:
    robot.pause()
    with pytest.raises(ControlError):
        robot.run(1.0)
    robot.step()
    robot.step(9)
    assert robot.time == pytest.approx(0.010)
    assert robot.joint_state.time == robot.time
    robot.resume()
    robot.run(0.010)
    assert robot.time == pytest.approx(0.020)


def test_a_reset_brings_time_and_pose_back(robot: tool0.Robot) -> None:
    robot.controller(ARM).follow([point([0.5, *HOME[1:]], 0.5)]).wait(5.0)
    robot.gripper.move(opening=0.04).wait(5.0)
    robot.reset()
    assert robot.time == robot.joint_state.time == 0.0
    assert tuple(robot.joint_state.position.values())[:7] == (*HOME, 0.0)
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
    elbow = summary["joints"]["elbow_joint"]
    assert elbow.keys() == {"position", "velocity", "effort"}
    assert 0.0 < summary["max_drift"] < 0.02  # the droop of the effort controller
    assert summary["overruns"] == 0


def test_the_summary_tells_where_the_yaml_says_what_nothing_reads() -> None:
    files = [POST, CONTROLLERS / "gazebo_controller.yaml"]
    with tool0.bringup(realtime=False, controllers_file=files) as robot:
        warnings = robot.summary()["warnings"]
    assert isinstance(warnings, list)
    assert all(w.keys() == {"file", "line", "key", "message"} for w in warnings)
    told = [(Path(w["file"]).name, w["line"], w["key"]) for w in warnings]
    assert ("ur5_controllers.yaml", 41, "gripper_controller/goal_tolerance") in told
    assert "gazebo_controller.yaml" in {file for file, *_ in told}


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
    with raises_naming(ConfigError, "'home'"):
        tool0.bringup(realtime=False, initial_pose="hme")


def test_a_controller_tells_its_parameters(robot: tool0.Robot) -> None:
    spec = robot.controller(ARM).spec
    assert spec.type == "effort_controllers/JointTrajectoryController"
    assert spec.joints[2] == "elbow_joint"
    robot.controller("joint_group_eff_controller").spec  # noqa: B018  # not running


def test_closing_twice_is_allowed_and_state_stays_readable(robot: tool0.Robot) -> None:
    robot.run(0.1)
    robot.close()
    robot.close()
    assert robot.time == pytest.approx(0.1)
    assert robot.joint_state.time == pytest.approx(0.1)
    with pytest.raises(ControlError):
        robot.reset()
