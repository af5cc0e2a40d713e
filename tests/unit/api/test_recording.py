"""``robot.record()`` in this process and over a connection."""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from raises_naming import raises_naming
from served import serving, use_folder
from ur5_rig import ARM

import tool0
from tool0.description.tool_poses import POSE
from tool0.errors import ControlError

pytestmark = pytest.mark.slow

ELBOW = "elbow_joint"


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False) as robot:
        yield robot


@pytest.mark.parametrize(
    ("asked", "rate"), [(500.0, 500.0), (300.0, 500.0), (125.0, 125.0), (50.0, 62.5)]
)
def test_every_sample_is_there(robot: tool0.Robot, asked: float, rate: float) -> None:
    with robot.record(rate=asked) as recording:
        for _ in range(10):  # commands publish snapshots of their own
            robot.run(0.4)
            robot.controller(ARM).steer({ELBOW: 1.5})
    n = round(4.0 * rate)
    assert recording.rate == pytest.approx(rate)
    assert recording.missed == 0
    assert len(recording) == n
    np.testing.assert_allclose(recording.time, np.arange(1, n + 1) / rate)


def test_the_arrays_are_what_snapshots_say(robot: tool0.Robot) -> None:
    with robot.record(rate=500) as recording:
        robot.move_joints({ELBOW: 1.0})[0].wait()
        robot.run(robot.control_period * (-robot.snapshot.tick % 8))
    snapshot, names = robot.snapshot, recording.joint_names
    shape = (len(recording), len(names))
    for array, last in (
        (recording.position, snapshot.position),
        (recording.velocity, snapshot.velocity),
        (recording.effort, snapshot.effort),
    ):
        assert array.shape == shape
        assert array[-1].tolist() == list(last)
    elbow = names.index(ELBOW)
    setpoint = snapshot.setpoints()[ELBOW]
    assert recording.desired_position.shape == recording.desired_velocity.shape == shape
    assert recording.desired_position[-1, elbow] == setpoint.position
    assert np.abs(recording.desired_velocity[:, elbow]).max() > 0.5
    error = recording.desired_position[:, elbow] - recording.position[:, elbow]
    assert 0.0 < np.abs(error).max() < 0.1
    follower = next(k for k, name in enumerate(names) if "inner_knuckle" in name)
    assert np.isnan(recording.desired_position[:, follower]).all()


def test_nothing_follows_after_the_stop_and_a_reset_is_recorded(
    robot: tool0.Robot,
) -> None:
    recording = robot.record()
    robot.run(0.08)
    assert len(recording) == 10  # also while it records
    robot.reset()
    robot.run(0.04)
    recording.stop()
    recording.stop()
    robot.run(0.1)
    times = [0.008 * k for k in (*range(1, 11), *range(6))]
    np.testing.assert_allclose(recording.time, times, atol=1e-12)
    assert recording.missed == 0


def test_a_recording_becomes_a_file(robot: tool0.Robot, tmp_path: Path) -> None:
    with robot.record() as recording:
        robot.run(0.04)
    recording.to_csv(tmp_path / "motion.csv")
    with (tmp_path / "motion.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 5
    assert tuple(rows[0]) == recording.columns
    elbow = recording.joint_names.index(ELBOW)
    for k, row in enumerate(rows):
        assert float(row["time"]) == recording.time[k]
        assert float(row[f"{ELBOW}.effort"]) == recording.effort[k, elbow]
    missing = [name for name, value in rows[0].items() if value == ""]
    assert missing
    assert all("desired" in name for name in missing)


def test_the_poses_of_flange_and_tcp_are_in_the_file(
    robot: tool0.Robot, tmp_path: Path
) -> None:
    with robot.record() as recording:
        robot.gripper.move(opening=0.03)
        robot.move_joints({ELBOW: 1.2})[0].wait()
        robot.run(robot.control_period * (-robot.snapshot.tick % 8))
    flange = robot.arm.pose()
    tcp = flange @ robot.gripper.tcp()
    recording.to_csv(tmp_path / "motion.csv")
    with (tmp_path / "motion.csv").open(encoding="utf-8") as file:
        *_, last = csv.DictReader(file)
    for name, pose in (("tool0", flange), ("gripper.tcp", tcp)):
        written = [float(last[f"{name}.{part}"]) for part in POSE]
        assert written == recording.tool_poses[name][-1].tolist()
        assert written[:3] == pytest.approx(pose.position, abs=1e-9)
        alike = abs(np.dot(written[3:], pose.quat_wxyz))
        assert alike == pytest.approx(1.0, abs=1e-12)


def test_a_recording_becomes_a_table_of_pandas(robot: tool0.Robot) -> None:
    pytest.importorskip("pandas")
    with robot.record() as recording:
        robot.run(0.04)
    table = recording.to_pandas()
    assert table.index.name == "time"
    assert table.index.tolist() == recording.time.tolist()
    assert tuple(table.columns) == recording.columns[1:]
    elbow = recording.joint_names.index(ELBOW)
    assert table[f"{ELBOW}.position"].tolist() == recording.position[:, elbow].tolist()


def test_pandas_is_named_where_it_is_missing(
    robot: tool0.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with robot.record() as recording:
        pass
    assert recording.position.shape == (0, len(recording.joint_names))
    with raises_naming(ControlError, "pip install pandas"):
        recording.to_pandas()


@pytest.mark.parametrize("rate", [0.0, -1.0, 501.0, math.nan])
def test_the_rate_has_bounds(robot: tool0.Robot, rate: float) -> None:
    with raises_naming(ControlError, "500"):
        robot.record(rate)


def test_another_process_records_the_same(
    robot: tool0.Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    use_folder(monkeypatch, tmp_path)
    with (
        serving(robot),
        tool0.connect() as remote,
        robot.record(rate=500) as here,
        remote.record(rate=500) as there,
    ):
        goal = remote.move_joints({ELBOW: 1.0})[0]
        for _ in range(20):
            remote.run(0.1)
        there.stop()
        assert goal.status is tool0.GoalStatus.SUCCEEDED
    assert there.joint_names == here.joint_names
    assert len(there) + there.missed == pytest.approx(len(here), abs=2)
    shared = np.isin(here.time, there.time)
    assert shared.sum() == len(there)
    np.testing.assert_array_equal(here.position[shared], there.position)
    np.testing.assert_array_equal(here.desired_position[shared], there.desired_position)
    assert there.time[-1] == here.time[-1]


def test_what_a_connection_drops_is_counted(
    robot: tool0.Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    use_folder(monkeypatch, tmp_path)
    with serving(robot), tool0.connect() as remote, remote.record(500) as recording:
        remote.run(0.1)
        remote.subscribe(125.0)  # one rate for the connection: three of four are lost
        remote.run(0.8)
    assert recording.missed >= 250
    assert len(recording) + recording.missed == pytest.approx(450, abs=2)


def test_a_robot_that_was_closed_leaves_its_recording() -> None:
    with tool0.bringup(realtime=False) as robot:
        recording = robot.record()
        robot.run(0.04)
    recording.stop()
    assert len(recording) == 5
