"""The commands that talk to a running bringup, against a fake robot."""

import json
import signal
import subprocess
import sys

import pytest
from fake_robot import ABORTED, ARM, GRIPPED, FakeRobot
from tool0.interfaces.socket.remote_gripper import RemoteGrasp

from tool0.cli import FAILED, GOAL_FAILED, INTERRUPTED, OK, main
from tool0.cli.grip import told
from tool0.control.goal import GoalStatus
from tool0.description.transform import Pose
from tool0.sensing.grasp import GraspState, GripperMotion

pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def robot(served_robot: FakeRobot) -> FakeRobot:
    return served_robot


def run(line: str) -> int:
    return main(line.split())


@pytest.mark.parametrize(
    ("line", "call"),
    [
        ("controllers load a", ("load", "a")),
        ("controllers unload a", ("unload", "a")),
        ("controllers start a b", ("switch", (("a", "b"), (), True))),
        ("controllers stop a", ("switch", ((), ("a",), True))),
        (
            "controllers switch --start a --stop b c --best-effort",
            ("switch", (("a",), ("b", "c"), False)),
        ),
        ("pause", ("pause", None)),
        ("resume", ("resume", None)),
        ("step", ("step", 1)),
        ("step 20", ("step", 20)),
        ("reset", ("reset", None)),
        ("estop", ("estop", True)),
        ("estop --release", ("estop", False)),
    ],
)
def test_a_command_is_one_call(
    line: str, call: tuple[str, object], robot: FakeRobot
) -> None:
    assert run(line) == OK
    assert robot.calls == [call]


def test_controllers_list_shows_every_one(
    robot: FakeRobot, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("controllers list") == OK
    rows = capsys.readouterr().out.splitlines()[1:]
    assert [row.split()[:3] for row in rows] == [
        [status.name, status.type, status.state] for status in robot.controllers()
    ]
    assert rows[0].split()[3:] == list(ARM)


def test_state_as_json_is_one_object(
    robot: FakeRobot, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("state --json") == OK
    state = json.loads(capsys.readouterr().out)
    assert state["time"] == robot.time
    assert state["position"] == robot.joint_state.position


def test_state_is_a_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("state") == OK
    out = capsys.readouterr().out
    assert "elbow_joint         -1.25000" in out
    assert "tool0: xyz +0.50000 +0.25000 -1.00000 m, rpy +0.00000" in out


def test_move_keeps_the_joints_that_are_not_given_where_they_are_desired(
    robot: FakeRobot, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("move --joints elbow_joint=-0.5 --duration 3") == OK
    assert capsys.readouterr().out == "SUCCEEDED\n"
    ((name, asked),) = robot.calls
    assert name == "arm_controller"
    assert asked["joint_names"] == ARM
    (point,) = asked["points"]
    assert point.positions == (1.0, 2.0, -0.5)
    assert point.time_from_start == 3.0


@pytest.mark.parametrize(
    ("options", "way", "asked"),
    [
        ("--speed 0.3 --tip pad", "to", {"speed": 0.3, "tip": "pad"}),
        ("--linear --relative-to tool0", "linear", {"relative_to": "tool0"}),
    ],
)
def test_move_takes_the_tool_to_a_pose(
    options: str, way: str, asked: dict[str, object], robot: FakeRobot
) -> None:
    assert run(f"move --pose 0.4 -0.1 0.3 3.14 0 -1.5 {options}") == OK
    pose = Pose(xyz=(0.4, -0.1, 0.3), rpy=(3.14, 0.0, -1.5))
    assert robot.calls == [(way, {"pose": pose, **asked})]


def test_a_goal_that_fails_exits_with_1(
    robot: FakeRobot, capsys: pytest.CaptureFixture[str]
) -> None:
    robot.outcome = ABORTED
    assert run("move --joints elbow_joint=1") == GOAL_FAILED
    assert "ABORTED (-4): elbow_joint path error" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("move --joints elbow=1", "claims joint 'elbow'; did you mean 'elbow_joint'"),
        ("move --joints elbow_joint", "write name=value"),
        ("move --joints elbow_joint=nan", "need a finite number"),
        ("move --joints elbow_joint=1 elbow_joint=2", "given twice"),
        ("move --joints elbow_joint=1 --duration 0", "--duration"),
        ("move --joints elbow_joint=1 --duration nan", "--duration"),
        ("move --joints elbow_joint=1 --controller spare_controller", "is running"),
        ("move", "either --joints"),
        ("move --joints a=1 --pose 0 0 0 0 0 0", "either --joints"),
        ("move --joints a=1 --linear", "--linear goes with --pose"),
        ("move --joints a=1 --tip b", "--tip goes with --pose"),
        ("move --pose 0 0 0 0 0 0 --duration 2", "--duration goes with --joints"),
        ("grip", "either --opening"),
        ("grip --opening 0.1", "outside"),
        ("grip --position 3", "outside"),
        ("grip --opening 0.01 --position 0.1", "either --opening"),
        ("controllers start", "at least one"),
        ("step 0", "1 or more"),
        ("state --name nobody", "no bringup named 'nobody'"),
        ("state --name ../x", "cannot be named"),
    ],
)
def test_a_mistake_is_one_line_and_moves_nothing(
    line: str, message: str, robot: FakeRobot, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(line) == FAILED
    error = capsys.readouterr().err
    assert error.startswith("tool0: error: ")
    assert error.count("\n") == 1
    assert message in error
    assert robot.calls == []


def test_grip_tells_what_it_holds(
    robot: FakeRobot, capsys: pytest.CaptureFixture[str]
) -> None:
    robot.outcome = GRIPPED
    assert run("grip --opening 0.04 --speed 0.05 --force 60") == OK
    assert "holds something 45.0 mm wide (gOBJ 2)\n" in capsys.readouterr().out
    assert run("state") == OK
    assert "jaw: holds something 45.0 mm wide (gOBJ 2)\n" in capsys.readouterr().out
    assert run("grip --opening 0.04 --effort 5") == OK
    asked = {"opening": 0.04, "speed": 0.05, "force": 60.0, "effort": None}
    other = {"opening": 0.04, "speed": None, "force": None, "effort": 5.0}
    assert robot.calls == [("jaw_controller", asked), ("jaw_controller", other)]


@pytest.mark.parametrize(
    ("motion", "text"),
    [
        ("holding_inside", "holds something 45.0 mm wide (gOBJ 2)"),
        ("holding_outside", "presses against something outside, open 45.0 mm (gOBJ 1)"),
        ("at_target", "open 45.0 mm (gOBJ 3)"),
        ("moving", "moving, open 45.0 mm (gOBJ 0)"),
        ("idle", "open 45.0 mm, commanded by nobody"),
    ],
)
def test_every_state_of_a_gripper_has_words(motion: GripperMotion, text: str) -> None:
    state = GraspState(motion=motion, opening=0.045)
    assert (
        told(RemoteGrasp(motion=motion, opening=0.045, width=None, gobj=state.gobj))
        == text
    )


def test_a_timeout_stops_the_robot(
    robot: FakeRobot, capsys: pytest.CaptureFixture[str]
) -> None:
    robot.outcome = None
    assert run("move --joints elbow_joint=1 --timeout 0.01") == GOAL_FAILED
    assert "PREEMPTED" in capsys.readouterr().out
    assert robot.goals[0].status is GoalStatus.PREEMPTED


@pytest.mark.parametrize("line", ["grip --opening 0", "move --joints elbow_joint=1"])
def test_a_goal_while_paused_says_what_it_waits_for(
    line: str, robot: FakeRobot, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(line) == OK
    assert not capsys.readouterr().err
    robot.is_paused = True
    assert run(line) == OK
    assert "the simulation is paused: `tool0 resume`" in capsys.readouterr().err


def test_ctrl_c_stops_the_robot(robot: FakeRobot) -> None:
    robot.outcome = None
    move = [sys.executable, "-m", "tool0", "move", "--joints", "elbow_joint=1"]
    with subprocess.Popen(move, stdout=subprocess.PIPE, text=True) as program:
        assert robot.has_begun.wait(30.0)
        program.send_signal(signal.SIGINT)
        assert program.stdout is not None
        assert "PREEMPTED" in program.stdout.read()
        assert program.wait() == INTERRUPTED
    assert robot.goals[0].status is GoalStatus.PREEMPTED
