"""``tool0 move`` and ``tool0 grip`` with a robot that runs."""

import contextlib
import json
import math
import re
import signal
import subprocess
import sys
from collections.abc import Callable

import pytest

import tool0
from tool0.cli import GOAL_FAILED, INTERRUPTED, OK, main
from tool0.cli.text import grasp_text
from tool0.description.grasp_frames import grasp_frame
from tool0.description.shapes import Box, Sphere
from tool0.description.transform import to_pose
from tool0.protocol.gripper import GraspState, GripperMotion

Capture = pytest.CaptureFixture[str]
ARM = "eff_joint_traj_controller"


def run(line: str) -> int:
    return main(line.split())


def test_move_keeps_the_joints_that_are_not_given(
    robot: tool0.Robot, capsys: Capture
) -> None:
    before, start = robot.joint_state.position, robot.time
    assert run("move --joints elbow_joint=1.2 wrist_1_joint=-1.3 --duration 3") == OK
    assert capsys.readouterr().out == "SUCCEEDED\n"
    assert robot.time - start > 2.9
    goals = {**before, "elbow_joint": 1.2, "wrist_1_joint": -1.3}
    after = robot.joint_state.position
    for name in robot.arm.joint_names:
        assert after[name] == pytest.approx(goals[name], abs=0.03)


def test_outcomes_are_json(robot: tool0.Robot, capsys: Capture) -> None:
    assert run("move --joints elbow_joint=1.2 --json") == OK
    assert json.loads(capsys.readouterr().out) == {
        "status": "SUCCEEDED",
        "error_code": 0,
        "error_string": "",
        "canceled": False,
    }
    assert run("move --joints elbow_joint=0 --timeout 0.001 --json") == GOAL_FAILED
    assert json.loads(capsys.readouterr().out)["canceled"]
    assert run("grip --opening 0.04 --json") == OK
    found = json.loads(capsys.readouterr().out)
    assert found["status"] == "SUCCEEDED"
    assert found["gripper"]["motion"] == "at_target"
    assert found["gripper"]["gobj"] == robot.gripper.state.gobj


def test_numbers_may_have_units(robot: tool0.Robot) -> None:
    assert run("move --joints elbow_joint=70deg shoulder_pan_joint=-10deg") == OK
    reached = robot.joint_state.position
    assert reached["elbow_joint"] == pytest.approx(math.radians(70.0), abs=0.03)
    assert reached["shoulder_pan_joint"] == pytest.approx(-math.radians(10), abs=0.03)
    assert run("grip --opening 40mm") == OK
    assert robot.gripper.opening == pytest.approx(0.04, abs=0.002)
    start = robot.arm.pose()
    x, y, z = (1e3 * part for part in start.position)
    roll, pitch, yaw = map(math.degrees, to_pose(start).rpy)
    line = f"move --pose {x}mm {y}mm {z - 50}mm {roll}deg {pitch}deg {yaw}deg"
    assert run(line) == OK
    assert robot.arm.pose().position[2] == pytest.approx(1e-3 * z - 0.05, abs=0.02)


@pytest.mark.parametrize(
    "line",
    ["move --joints elbow_joint=1", "move --pose 0.4 0.1 0.3 180deg 0 0"],
)
def test_a_stopped_controller_is_named_with_the_command_that_starts_it(
    line: str, robot: tool0.Robot, refused: Callable[[str], str]
) -> None:
    robot.switch(stop=[ARM])
    try:
        said = refused(line)
    finally:
        robot.switch(start=[ARM])
    assert f"controller '{ARM}' is stopped" in said
    assert f"`tool0 controllers start {ARM}`" in said
    assert "did you mean" not in said


def test_a_controller_that_runs_instead_is_named(
    robot: tool0.Robot, refused: Callable[[str], str]
) -> None:
    other = "joint_group_eff_controller"
    robot.switch(stop=[ARM], start=[other])
    try:
        said = refused("move --joints elbow_joint=1")
    finally:
        robot.switch(stop=[other], start=[ARM])
    assert f"`tool0 controllers switch --stop {other} --start {ARM}`" in said


def test_move_by_a_named_controller(robot: tool0.Robot) -> None:
    assert run(f"move --joints elbow_joint=1.4 --controller {ARM}") == OK
    assert robot.joint_state.position["elbow_joint"] == pytest.approx(1.4, abs=0.03)


@pytest.mark.parametrize(
    ("options", "tip", "relative_to"),
    [
        ("--speed 0.3 --tip robotiq_arg2f_base_link", "robotiq_arg2f_base_link", None),
        ("--linear --relative-to base", "tool0", "base"),
    ],
)
def test_move_takes_the_tool_to_a_pose(
    options: str, tip: str, relative_to: str | None, robot: tool0.Robot
) -> None:
    start = robot.arm.pose(tip=tip, relative_to=relative_to)
    x, y, z = start.position
    roll, pitch, yaw = to_pose(start).rpy
    line = f"move --pose {x} {y} {z - 0.05} {roll} {pitch} {yaw} {options}"
    assert run(line) == OK
    reached = robot.arm.pose(tip=tip, relative_to=relative_to).position
    assert reached == pytest.approx((x, y, z - 0.05), abs=0.02)


def test_a_goal_that_fails_exits_with_1(robot: tool0.Robot, capsys: Capture) -> None:
    robot.scene.add("wall", Box(size=(0.6, 0.1, 0.8)), xyz=(0.6, 0.35, 0.3))
    line = "move --joints shoulder_pan_joint=1.2 --duration 6 --collision ignore"
    assert run(line) == GOAL_FAILED
    failure = r"ABORTED \(-4\): .*shoulder_pan_joint.*'wall'"
    assert re.match(failure, capsys.readouterr().out)


def add_wall(robot: tool0.Robot) -> None:
    """Add what is in the way when the arm turns to the left, but not above it."""
    robot.scene.add("wall", Box(size=(0.6, 0.05, 0.5)), xyz=(0.6, 0.35, 0.15))


TO_THE_LEFT = "move --joints shoulder_pan_joint=1.2"


def test_a_motion_that_would_collide_is_refused_with_the_bodies(
    robot: tool0.Robot, refused: Callable[[str], str]
) -> None:
    add_wall(robot)
    robot.run(0.1)
    assert re.search(r"would collide after .* s, .*'wall'", refused(TO_THE_LEFT))


def test_a_check_says_whether_a_motion_is_free(
    robot: tool0.Robot, capsys: Capture
) -> None:
    setpoints = robot.snapshot.setpoints()
    assert run(f"{TO_THE_LEFT} --check") == OK
    assert capsys.readouterr().out == "free\n"
    add_wall(robot)
    assert run(f"{TO_THE_LEFT} --check") == GOAL_FAILED
    blocked = r"not free: at \d+% of the way, '\w+' would be \d.* mm in 'wall'\n"
    assert re.fullmatch(blocked, capsys.readouterr().out)
    assert run(f"{TO_THE_LEFT} --check --json") == GOAL_FAILED
    found = json.loads(capsys.readouterr().out)
    assert not found["is_free"]
    assert 0.0 < found["part"] < 1.0
    assert "'wall'" in found["reason"]
    assert robot.snapshot.setpoints() == setpoints


def test_a_check_of_a_line_and_with_a_clearance(
    robot: tool0.Robot, capsys: Capture
) -> None:
    x, y, z = robot.arm.pose().position
    roll, pitch, yaw = to_pose(robot.arm.pose()).rpy
    line = f"move --pose {x} {y + 0.05} {z} {roll} {pitch} {yaw} --linear --check"
    robot.scene.add("wall", Box(size=(0.6, 0.05, 0.5)), xyz=(0.6, y + 0.2, 0.25))
    assert run(line) == OK
    assert capsys.readouterr().out == "free\n"
    assert run(f"{line} --clearance 100mm") == GOAL_FAILED
    assert "nearer than 100.0 mm" in capsys.readouterr().out


def test_a_plan_goes_around(robot: tool0.Robot, capsys: Capture) -> None:
    add_wall(robot)
    setpoints = robot.snapshot.setpoints()
    assert run(f"{TO_THE_LEFT} --plan --check") == OK
    text = r"around by \d waypoints?, \d.* s; \d.* mm apart: .* planned in \d+ ms\n"
    assert re.fullmatch(text, capsys.readouterr().out)
    assert robot.snapshot.setpoints() == setpoints
    assert run(f"{TO_THE_LEFT} --plan --check --clearance 400mm") == GOAL_FAILED
    assert "nearer than 400.0 mm" in capsys.readouterr().out
    assert run(f"{TO_THE_LEFT} --plan --json") == OK
    found = json.loads(capsys.readouterr().out)
    assert found["status"] == "SUCCEEDED"
    assert not found["plan"]["is_direct"]
    assert found["plan"]["clearance"] >= 0.005
    pan = robot.joint_state.position["shoulder_pan_joint"]
    assert pan == pytest.approx(1.2, abs=0.03)
    assert not any("wall" in (c.first, c.second) for c in robot.contacts())


def test_a_target_in_an_obstacle_is_named(
    robot: tool0.Robot, capsys: Capture, refused: Callable[[str], str]
) -> None:
    line = "move --pose 0.3 -0.5 0.2 180deg 0 0 --plan"
    robot.scene.add("block", Box(size=(0.2, 0.2, 0.3)), xyz=(0.3, -0.5, 0.15))
    assert run(f"{line} --check") == GOAL_FAILED
    said = capsys.readouterr().out
    assert said.startswith("not free: no posture of the target is free")
    assert "'block'" in said
    assert run(f"{line} --check --json") == GOAL_FAILED
    assert not json.loads(capsys.readouterr().out)["is_free"]
    assert "no posture of the target is free" in refused(line)


@pytest.mark.parametrize(
    ("line", "named"),
    [
        ("move --joints elbow_joint=1 --speed 0.5", "--speed needs --pose or --plan"),
        ("move --joints elbow_joint=1 --clearance 5mm", "--check or --plan"),
        ("move --joints elbow_joint=1 --plan --duration 3", "--plan has no"),
        ("move --pose 0.4 0 0.3 180deg 0 0 --plan --linear", "--plan has no"),
        ("move --joints elbow_joint=1 --check --collision ignore", "--collision"),
        ("move --joints finger_joint=0.1 --check", "'finger_joint' is not a joint of"),
        ("move --joints elbow=1", "'elbow_joint'"),
        ("move --joints elbow_joint", "'elbow_joint'"),
        ("move --joints elbow_joint=nan", "elbow_joint='nan'"),
        ("move --joints elbow_joint=1 elbow_joint=2", "'elbow_joint'"),
        ("move --joints elbow_joint=1 --duration 0", "--duration"),
        ("move --joints elbow_joint=-1.4 --duration 0.05", "at least 1.5 s"),
        ("move --joints elbow_joint=1 --duration nan", "--duration"),
        (
            "move --joints elbow_joint=1 --controller joint_group_eff_controller",
            "'joint_group_eff_controller'",
        ),
        ("move", "--joints"),
        ("move --joints a=1 --pose 0 0 0 0 0 0", "--pose"),
        ("move --joints a=1 --linear", "--linear"),
        ("move --joints a=1 --tip b", "--tip"),
        ("move --pose 0 0 0 0 0 0 --duration 2", "--duration"),
        ("move --pose 0 0 0 0 0 0 --robot left", "'left'"),
        ("grip", "--opening"),
        ("grip --opening 0.1", "0.085"),
        ("grip --position 3", "3.0"),
        ("grip --opening 0.01 --position 0.1", "--position"),
        ("move --joints elbow_joint=90", "did you mean 90deg = 1.571 rad?"),
        ("move --joints elbow_joint=40mm", "'elbow_joint' is rad or deg, not m or mm"),
        ("move --joints elbow_joint=1cm", "need a number, alone or with rad, deg, m"),
        ("move --pose 0.4 0 0.3 180 0 0", "did you mean 180deg = 3.142 rad?"),
        ("move --pose 0.4 0 0.3 90mm 0 0", "'mm' is not a unit here"),
        ("grip --opening 40", "did you mean 40mm = 0.04 m?"),
        ("grip --opening 40deg", "--opening: '40deg'"),
        ("grip --position 45", "did you mean 45deg = 0.7854 rad?"),
    ],
)
def test_a_mistake_is_one_line_and_moves_nothing(
    line: str, named: str, refused: Callable[[str], str]
) -> None:
    assert named in refused(line)


def test_grip_tells_what_it_holds(robot: tool0.Robot, capsys: Capture) -> None:
    gripper = robot.gripper
    robot.run(1.0)  # the arm has settled: the pads meet the middle of the ball
    frame = grasp_frame(robot.description.model, gripper.geometry, 0.045, "tool0")
    position = (robot.pose("tool0") @ frame).position
    robot.scene.add("ball", Sphere(radius=0.0225), xyz=position)
    assert run("grip --opening 0 --speed 0.05 --force 60") == OK
    held = re.search(r"(\d\d\.\d) mm wide \(gOBJ 2\)\n", capsys.readouterr().out)
    assert held is not None
    assert float(held[1]) == pytest.approx(45.0, abs=5.0)
    assert run("state") == OK
    assert "gripper: holds an object " in capsys.readouterr().out
    assert run("grip --position 0 --effort 5") == OK
    assert gripper.opening == pytest.approx(0.085, abs=2e-3)


@pytest.mark.parametrize(
    ("motion", "text"),
    [
        ("holding_inside", "holds an object 45.0 mm wide (gOBJ 2)"),
        ("holding_outside", "holds an object from inside, open 45.0 mm (gOBJ 1)"),
        (
            "blocked",
            "blocked without an object between the pads, open 45.0 mm (gOBJ 0)",
        ),
        ("at_target", "open 45.0 mm (gOBJ 3)"),
        ("moving", "moving, open 45.0 mm (gOBJ 0)"),
        ("idle", "open 45.0 mm, not commanded"),
    ],
)
def test_every_state_of_a_gripper_has_words(motion: GripperMotion, text: str) -> None:
    assert grasp_text(GraspState(motion=motion, opening=0.045)) == text


def test_a_timeout_stops_the_robot(robot: tool0.Robot, capsys: Capture) -> None:
    line = "move --joints elbow_joint=1 --duration 600 --timeout 0.01"
    assert run(line) == GOAL_FAILED
    assert "PREEMPTED" in capsys.readouterr().out


def test_a_goal_while_paused_says_what_it_waits_for(
    robot: tool0.Robot, capsys: Capture
) -> None:
    robot.pause()
    assert run("grip --opening 0.02 --timeout 0.01") == GOAL_FAILED
    assert "`tool0 resume`" in capsys.readouterr().err
    robot.resume()
    assert run("grip --opening 0.02") == OK
    assert not capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_stops_the_robot(number: signal.Signals, robot: tool0.Robot) -> None:
    move = ["move", "--joints", "elbow_joint=-1", "--duration", "20"]
    with (
        contextlib.closing(robot.subscribe()) as states,
        subprocess.Popen(
            [sys.executable, "-m", "tool0", *move], stdout=subprocess.PIPE, text=True
        ) as program,
    ):
        while robot.joint_state.position["elbow_joint"] > 1.5:
            states.following(1.0)
        program.send_signal(number)
        out, _ = program.communicate(timeout=30.0)
    assert "PREEMPTED" in out
    assert program.returncode == INTERRUPTED
    assert robot.joint_state.position["elbow_joint"] > 0.0
