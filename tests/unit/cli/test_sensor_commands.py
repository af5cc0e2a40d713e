"""``tool0 state``, ``wrench`` and ``camera`` with a robot that runs."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from promised import require_gl

import tool0
from tool0.cli import OK, main
from tool0.recording.png import encode_depth, encode_png

Capture = pytest.CaptureFixture[str]


def run(line: str) -> int:
    return main(line.split())


@pytest.fixture
def paused(robot: tool0.Robot) -> tool0.Robot:
    robot.pause()
    return robot


def test_state_as_json_is_one_object(paused: tool0.Robot, capsys: Capture) -> None:
    assert run("state --json") == OK
    state = json.loads(capsys.readouterr().out)
    assert state["time"] == paused.time
    assert state["is_paused"]
    assert state["position"] == paused.joint_state.position
    assert state["velocity"] == paused.joint_state.velocity
    assert state["effort"] == paused.joint_state.effort
    assert state["grippers"]["gripper"]["gobj"] == paused.gripper.state.gobj
    assert state["poses"]["tool0"]["xyz"] == pytest.approx(paused.arm.pose().position)


def test_state_is_a_table(paused: tool0.Robot, capsys: Capture) -> None:
    paused.emergency_stop()
    assert run("state") == OK
    head, *rows, gripper, tool = capsys.readouterr().out.splitlines()
    assert head.startswith(f"t = {paused.time:.3f} s")
    assert head.endswith("paused, emergency stop")
    shown = {row.split()[0]: float(row.split()[1]) for row in rows[1:]}
    assert shown == pytest.approx(paused.joint_state.position, abs=1e-5)
    assert gripper.startswith("gripper: open 8")
    numbers = [float(word) for word in tool.split() if word[0] in "+-"]
    assert numbers[:3] == pytest.approx(paused.arm.pose().position, abs=1e-5)


def test_wrench_as_json_is_an_object_for_each_sample(
    robot: tool0.Robot, capsys: Capture
) -> None:
    assert run("wrench --duration 0.04 --json") == OK
    samples = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert len(samples) > 1
    assert {item["frame"] for item in samples} == {"tool0"}
    assert all(len(item["raw_force"]) == len(item["torque"]) == 3 for item in samples)


def forces(capsys: Capture) -> list[list[float]]:
    """Return the forces that were printed [N]."""
    lines = capsys.readouterr().out.splitlines()
    return [[float(word) for word in line.split()[5:8]] for line in lines]


def test_wrench_prints_every_sample_of_a_while(
    robot: tool0.Robot, capsys: Capture
) -> None:
    assert run("wrench --rate 500 --cutoff 5 --duration 0.04") == OK
    assert robot.force_torque.rate == 500.0
    lines = capsys.readouterr().out.splitlines()
    times = [float(line.split()[2]) for line in lines]
    assert times == pytest.approx([times[0] + 0.002 * k for k in range(21)], abs=2e-3)


def test_wrench_prints_the_weight_of_the_gripper_until_it_is_tared(
    robot: tool0.Robot, capsys: Capture
) -> None:
    assert run("wrench --duration 1.5 --raw") == OK  # it settles after a reset
    weight = forces(capsys)[-1]
    assert weight == pytest.approx([0.0, 0.0, 9.03], abs=0.1)
    assert run("wrench --zero") == OK
    assert forces(capsys) == [pytest.approx([0.0, 0.0, 0.0], abs=0.1)]


def test_camera_lists_the_cameras(robot: tool0.Robot, capsys: Capture) -> None:
    assert run("camera --list") == OK
    rows = [line.split() for line in capsys.readouterr().out.splitlines()[1:]]
    assert [row[0] for row in rows] == list(robot.cameras)
    assert rows[0][1:6] == ["tool0", "640", "x", "480", "58°"]
    assert run("camera --list --json") == OK
    first, *_ = json.loads(capsys.readouterr().out)["cameras"]
    assert (first["name"], first["link"], first["width"]) == ("wrist", "tool0", 640)


def test_camera_writes_colors_and_depth(
    paused: tool0.Robot, tmp_path: Path, capsys: Capture
) -> None:
    require_gl()
    out, depth, array = (tmp_path / name for name in ("a.png", "d.png", "d.npy"))
    assert run(f"camera scene --out {out} --depth {depth}") == OK
    assert capsys.readouterr().out == (
        f"{out}, {depth}: 640 x 480, at t = {paused.time:.3f} s\n"
    )
    image = paused.camera("scene").image()
    assert out.read_bytes() == encode_png(image.rgb)
    assert depth.read_bytes() == encode_depth(image.depth)
    assert run(f"camera scene --depth {array}") == OK
    written = np.load(array)
    assert written.dtype == np.float32
    assert np.array_equal(written, image.depth)


@pytest.mark.parametrize(
    ("line", "named"),
    [
        ("wrench --rate 20", "[50, 1000] Hz"),
        ("wrench --duration -1", "-1.0"),
        ("camera", "--list"),
        ("camera scene --list", "--list"),
        ("camera scene", "--out"),
        ("camera scene --out a.jpg", ".png"),
        ("camera scene --depth a.exr", ".npy"),
        ("camera scen --out a.png", "'scene'"),
    ],
)
def test_a_mistake_is_one_line_and_writes_nothing(
    line: str,
    named: str,
    refused: Callable[[str], str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert named in refused(line)
    assert not list(tmp_path.glob("a.*"))


def test_a_picture_that_cannot_be_written_is_named(
    refused: Callable[[str], str], tmp_path: Path
) -> None:
    require_gl()
    assert "absent/a.png" in refused(f"camera scene --out {tmp_path}/absent/a.png")
