"""``tool0 controllers``, ``pause``, ``step``, … with a robot that runs."""

import json
from collections.abc import Callable

import pytest

import tool0
from tool0.cli import FAILED, OK, main

Capture = pytest.CaptureFixture[str]
ARM, OTHER = "eff_joint_traj_controller", "joint_group_eff_controller"


def run(line: str) -> int:
    return main(line.split())


def states(robot: tool0.Robot) -> dict[str, str]:
    return {status.name: status.state for status in robot.controllers()}


def test_controllers_list_shows_every_one(robot: tool0.Robot, capsys: Capture) -> None:
    assert run("controllers list") == OK
    rows = capsys.readouterr().out.splitlines()[1:]
    assert [row.split()[:3] for row in rows] == [
        [status.name, status.type, status.state] for status in robot.controllers()
    ]
    (arm,) = (row.split() for row in rows if row.startswith(ARM))
    assert arm[3:] == list(robot.arm.joint_names)


def test_controllers_gains_and_time_are_json(
    robot: tool0.Robot, capsys: Capture
) -> None:
    assert run("controllers list --json") == OK
    rows = json.loads(capsys.readouterr().out)["controllers"]
    assert [row["name"] for row in rows] == list(states(robot))
    (arm,) = (row for row in rows if row["name"] == ARM)
    assert (arm["role"], arm["is_running"]) == ("trajectory", True)
    interface = "hardware_interface/EffortJointInterface"
    assert arm["claimed"] == [[interface, list(robot.arm.joint_names)]]
    assert run(f"controllers gains {ARM} --json") == OK
    gains = json.loads(capsys.readouterr().out)["gains"]
    assert gains["elbow_joint"]["p"] == robot.controller(ARM).gains["elbow_joint"].p
    robot.pause()
    assert run("step 2 --json") == OK
    assert json.loads(capsys.readouterr().out) == {"time": robot.time}


def test_controllers_are_stopped_loaded_started_and_switched(
    robot: tool0.Robot,
) -> None:
    assert run(f"controllers stop {ARM} gripper_controller") == OK
    assert states(robot)[ARM] == states(robot)["gripper_controller"] == "stopped"
    assert run(f"controllers unload {OTHER}") == OK
    assert OTHER not in states(robot)
    assert run(f"controllers load {OTHER}") == OK
    assert states(robot)[OTHER] == "initialized"
    assert run(f"controllers start {OTHER} gripper_controller") == OK
    assert states(robot)[OTHER] == states(robot)["gripper_controller"] == "running"
    line = f"controllers switch --start {ARM} nobody --stop {OTHER} --best-effort"
    assert run(line) == OK
    assert states(robot)[ARM] == "running"
    assert states(robot)[OTHER] == "stopped"


def test_gains_are_printed_and_changed(robot: tool0.Robot, capsys: Capture) -> None:
    before = robot.controller(ARM).gains["elbow_joint"]
    assert (
        run(f"controllers gains {ARM} --joint elbow_joint --p 1500 --i-clamp 7") == OK
    )
    (row,) = (
        line.split()[1:]
        for line in capsys.readouterr().out.splitlines()
        if line.startswith("elbow_joint")
    )
    assert [float(value) for value in row] == [1500.0, before.i, before.d, -7.0, 7.0]
    assert robot.controller(ARM).gains["elbow_joint"].p == 1500.0
    assert run(f"controllers gains {ARM} --p 1") == FAILED


def test_time_is_paused_stepped_and_resumed(
    robot: tool0.Robot, capsys: Capture
) -> None:
    assert run("pause") == OK
    assert robot.snapshot.is_paused
    start = robot.time
    assert run("step") == OK
    assert run("step 20") == OK
    assert robot.time == pytest.approx(start + 21 * robot.control_period)
    assert capsys.readouterr().out.splitlines()[-1] == f"t = {robot.time:.3f} s"
    assert run("resume") == OK
    assert not robot.snapshot.is_paused


def test_reset_returns_to_the_start(robot: tool0.Robot) -> None:
    robot.pause()
    assert run("reset") == OK
    assert robot.time == 0.0


def test_the_emergency_stop_is_engaged_and_released(robot: tool0.Robot) -> None:
    assert run("estop") == OK
    assert robot.snapshot.is_stopped
    assert run("estop --release") == OK
    assert not robot.snapshot.is_stopped


@pytest.mark.parametrize(
    ("line", "named"),
    [
        ("controllers start", "CONTROLLER ... is missing"),
        ("controllers switch", "--start CONTROLLER"),
        ("controllers load nobody", "'nobody'"),
        (f"controllers start {OTHER}", "'shoulder_pan_joint'"),
        (f"controllers unload {ARM}", f"'{ARM}'"),
        ("step 0", "0"),
        ("step", "pause"),
        ("state --name nobody", "'nobody'"),
        ("state --name ../x", "'../x'"),
    ],
)
def test_a_mistake_is_one_line_and_changes_nothing(
    line: str, named: str, refused: Callable[[str], str]
) -> None:
    assert named in refused(line)
