"""Commands to one robot of a cell, and the cell on the command line."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from promised import require_gl
from served import serving

import tool0
from tool0.cli import FAILED, GOAL_FAILED, OK, main

Capture = pytest.CaptureFixture[str]
TWINS = ["left=ur5+2f85@0,0.45,0", "right=ur5@0,-0.45,0"]


@pytest.fixture(scope="module")
def cell(runtime_folder: Path) -> Iterator[tool0.Robot]:
    description = tool0.DescriptionConfig(robots=TWINS)
    with tool0.bringup(description=description, speed=10.0) as robot, serving(robot):
        yield robot


def run(line: str) -> int:
    return main(line.split())


@pytest.mark.slow
def test_joints_of_a_robot_need_no_prefix(cell: tool0.Robot) -> None:
    assert run("move --robot right --joints elbow_joint=1.2") == OK
    position = cell.joint_state.position
    assert position["right_elbow_joint"] == pytest.approx(1.2, abs=0.03)
    assert position["left_elbow_joint"] == pytest.approx(1.57, abs=0.03)
    assert run("move --joints left_wrist_3_joint=0.4") == OK
    position = cell.joint_state.position
    assert position["left_wrist_3_joint"] == pytest.approx(0.4, abs=0.03)


@pytest.mark.slow
def test_joints_of_both_robots_move_at_once(cell: tool0.Robot, capsys: Capture) -> None:
    joints = "left_wrist_3_joint=0.2 right_wrist_3_joint=-0.3"
    assert run(f"move --joints {joints} --duration 1") == OK
    position = cell.joint_state.position
    assert position["left_wrist_3_joint"] == pytest.approx(0.2, abs=0.03)
    assert position["right_wrist_3_joint"] == pytest.approx(-0.3, abs=0.03)
    capsys.readouterr()
    joints = "left_wrist_3_joint=0.0 right_wrist_3_joint=2.0"
    assert run(f"move --joints {joints} --duration 600 --timeout 0.3") == GOAL_FAILED
    assert "canceled: PREEMPTED" in capsys.readouterr().out
    cell.run(1.0)
    assert max(abs(v) for v in cell.joint_state.velocity.values()) < 1e-2


def test_the_tool_of_a_robot_moves_to_a_pose(cell: tool0.Robot) -> None:
    assert run("move --robot left --pose 0.4 0.5 0.3 180deg 0 0") == OK
    pose = cell.arms["left"].pose()
    assert pose.position == pytest.approx((0.4, 0.5, 0.3), abs=0.02)


def test_the_gripper_and_the_wrench_of_a_robot(
    cell: tool0.Robot, capsys: Capture
) -> None:
    assert run("grip --robot left --opening 30mm") == OK
    assert cell.grippers["left"].opening == pytest.approx(0.03, abs=2e-3)
    capsys.readouterr()
    assert run("wrench --robot right") == OK
    assert capsys.readouterr().out.endswith("right_tool0\n")


def test_the_camera_of_a_robot(
    cell: tool0.Robot, capsys: Capture, tmp_path: Path
) -> None:
    require_gl()
    assert run(f"camera wrist --robot left --out {tmp_path / 'a.png'}") == OK
    assert (tmp_path / "a.png").stat().st_size > 1000
    assert run("camera --list") == OK
    assert "right_wrist" in capsys.readouterr().out


def test_state_shows_all_robots(cell: tool0.Robot, capsys: Capture) -> None:
    assert run("state --json") == OK
    state = json.loads(capsys.readouterr().out)
    assert list(state["grippers"]) == ["left"]
    assert list(state["poses"]) == ["left_tool0", "right_tool0"]
    assert {"left_elbow_joint", "right_elbow_joint"} < set(state["position"])


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("wrench", "which robot? give --robot left | right"),
        ("move --pose 0.4 0.5 0.3 0 0 0", "which robot? give --robot left | right"),
        ("wrench --robot lef", "no robot 'lef'; did you mean 'left'?"),
        ("grip --robot right --opening 0", "robot 'right' has no gripper"),
        ("move --robot rigth --joints elbow_joint=1", "did you mean 'right'?"),
    ],
)
def test_a_missing_or_wrong_robot_is_one_line(
    line: str, said: str, cell: tool0.Robot, capsys: Capture
) -> None:
    assert run(line) == FAILED
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_describe_writes_a_cell(tmp_path: Path, capsys: Capture) -> None:
    file = tmp_path / "press.yaml"
    file.write_text("robots: [{name: one, arm: ur5, gripper: 2f85}]")
    assert run(f"describe urdf --cell {file}") == OK
    assert '<robot name="press">' in capsys.readouterr().out
    assert main(["describe", "table", "--robots", *TWINS]) == OK
    rows = capsys.readouterr().out
    assert "left_finger_joint" in rows
    assert "right_elbow_joint" in rows
    assert main(["describe", "controllers", "--robots", *TWINS]) == OK
    yaml = capsys.readouterr().out
    assert "left_gripper_controller:" in yaml
    assert "right_eff_joint_traj_controller:" in yaml
    assert yaml.count("\njoint_state_controller:") == 1


def test_bringup_names_each_robot(runtime_folder: Path, capsys: Capture) -> None:
    line = "bringup --headless --no-realtime --duration 0.01 --no-remote --robots"
    assert main([*line.split(), *TWINS]) == OK
    assert "left: ur5 + 2f85, right: ur5 is up in mujoco" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--cell", "a.yaml", "--robots", *TWINS], "only one of cell, robots"),
        (["--arm", "ur5", "--robots", *TWINS], "arm"),
        (["--cell", "no.yaml"], "no.yaml"),
        (["--robots", "left"], "NAME=ARM"),
    ],
    ids=str,
)
def test_wrong_cells_are_one_line(
    options: list[str], said: str, capsys: Capture
) -> None:
    assert main(["describe", "tree", *options]) == FAILED
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
