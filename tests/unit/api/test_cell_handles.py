"""The robots of a cell through the API, in the process and over the socket."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from raises_naming import raises_naming
from served import serving, use_folder

import tool0
from tool0.errors import ConfigError, ControlError

CELL = """
robots:
  - {name: left, arm: ur5, gripper: 2f85, base: {xyz: [0, 0.5, 0]}}
  - name: right
    arm: ur5
    gripper: 2f85
    base: {xyz: [0, -0.5, 0]}
    initial_pose: {elbow_joint: 1.2}
"""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    file = tmp_path / "twins.yaml"
    file.write_text(CELL)
    return file


@pytest.fixture(params=["local", "remote"])
def robot(
    request: pytest.FixtureRequest,
    path: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> Iterator[tool0.Robot]:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    is_remote = request.param == "remote"  # where time must pass by itself
    with tool0.bringup(cell=path, realtime=is_remote, speed=20.0) as local:
        if not is_remote:
            yield local
            return
        use_folder(monkeypatch, tmp_path)
        with serving(local), tool0.connect() as remote:
            yield remote


def moved(robot: tool0.Robot, before: dict[str, float]) -> set[str]:
    """Return the robots with a joint elsewhere than ``before``."""
    now = robot.joint_state.position
    return {
        name.partition("_")[0] for name in now if abs(now[name] - before[name]) > 0.05
    }


@pytest.mark.slow
def test_arms_grippers_sensors_and_cameras_go_by_the_robots_names(
    robot: tool0.Robot,
) -> None:
    assert list(robot.arms) == list(robot.grippers) == ["left", "right"]
    assert list(robot.cameras) == ["left_wrist", "right_wrist", "scene"]
    assert [item.name for item in robot.description.robots] == ["left", "right"]
    assert robot.arms["left"].force_torque.read().frame == "left_tool0"
    assert robot.arms["right"].pose().position[1] < 0.0
    with raises_naming(ControlError, "left, right"):
        _ = robot.arm
    with raises_naming(ControlError, "left, right"):
        _ = robot.gripper


def test_each_robot_starts_where_the_file_says(robot: tool0.Robot) -> None:
    position = robot.joint_state.position
    assert position["right_elbow_joint"] == pytest.approx(1.2, abs=0.02)
    assert position["left_elbow_joint"] == pytest.approx(1.5708, abs=0.02)


@pytest.mark.slow
def test_a_pose_moves_all_robots_or_one(robot: tool0.Robot) -> None:
    before = dict(robot.joint_state.position)
    for goal in robot.go_to_pose("up", robot="left"):
        goal.wait(20)
    assert moved(robot, before) == {"left"}
    for goal in robot.arms["right"].go_to_pose("up"):
        goal.wait(20)
    assert moved(robot, before) == {"left", "right"}
    before = dict(robot.joint_state.position)
    for goal in robot.go_to_pose("home"):
        goal.wait(20)
    assert moved(robot, before) == {"left", "right"}
    with raises_naming(ControlError, "'lefd'", "'left'"):
        robot.go_to_pose("home", robot="lefd")


def test_a_saved_pose_holds_all_robots_or_one(robot: tool0.Robot) -> None:
    robot.save_pose("both")
    robot.save_pose("mine", robot="left")
    poses = robot.poses()
    assert {name.partition("_")[0] for name in poses["mine"].positions} == {"left"}
    assert set(poses["mine"].positions) < set(poses["both"].positions)
    with raises_naming(ControlError, "'right'"):
        robot.go_to_pose("mine", robot="right")


def test_grippers_move_independently(robot: tool0.Robot) -> None:
    robot.grippers["left"].move(opening=0.02).wait(5)
    assert robot.grippers["left"].opening == pytest.approx(0.02, abs=2e-3)
    assert robot.grippers["right"].opening == pytest.approx(0.085, abs=2e-3)
    assert robot.grippers["left"].wait(2).motion == "at_target"


def test_an_initial_pose_applies_to_all_robots(path: Path) -> None:
    with tool0.bringup(cell=path, initial_pose="up", realtime=False) as robot:
        position = robot.joint_state.position
        assert position["left_elbow_joint"] == position["right_elbow_joint"] == 0.0


OWN = """
joint_state_controller: {type: joint_state_controller/JointStateController}
eff_joint_traj_controller:
  type: effort_controllers/JointTrajectoryController
  joints: [shoulder_pan_joint, shoulder_lift_joint]
  gains:
    shoulder_pan_joint: {p: 4321, d: 60}
    shoulder_lift_joint: {p: 8000, d: 200}
"""


def test_a_robots_own_controllers_replace_its_built_in_ones(
    path: Path, tmp_path: Path
) -> None:
    (tmp_path / "own.yaml").write_text(OWN)
    path.write_text(CELL.replace("0.5, 0]}}", "0.5, 0]}, controllers_file: own.yaml}"))
    with tool0.bringup(cell=path, realtime=False) as robot:
        assert robot.warnings == ()
        running = [item.name for item in robot.controllers() if item.state == "running"]
        assert running == [
            "joint_state_controller",
            "left_eff_joint_traj_controller",
            "right_eff_joint_traj_controller",
            "right_gripper_controller",
        ]
        gains = robot.controller("left_eff_joint_traj_controller").gains
        assert list(gains) == ["left_shoulder_pan_joint", "left_shoulder_lift_joint"]
        assert gains["left_shoulder_pan_joint"].p == 4321


def test_own_controllers_that_do_not_exist_name_the_file(path: Path) -> None:
    path.write_text(CELL.replace("0.5, 0]}}", "0.5, 0]}, controllers_file: no.yaml}"))
    with raises_naming(ConfigError, "no.yaml"):
        tool0.bringup(cell=path, realtime=False)
