"""``tool0 record``, ``log`` and ``export``."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from served import serving

import tool0
from tool0.cli import FAILED, OK, main

pytestmark = pytest.mark.slow

ELBOW = "elbow_joint"


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short recording of a motion."""
    path = tmp_path_factory.mktemp("recorded") / "motion.mcap"
    with tool0.bringup(realtime=False, gripper=None, record=path) as robot:
        robot.move_joints({ELBOW: 1.6})[0].wait()
        robot.emergency_stop()
        robot.run(0.1)
    return path


def test_record_writes_what_a_running_bringup_does(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "live.mcap"
    name = "recorded"
    with tool0.bringup(gripper=None) as robot, serving(robot, name):
        words = ["--duration", "0.3", "--name", name, "--json"]
        status = main(["record", str(path), *words])
        assert robot.recording is not None
    assert status == OK
    recording = tool0.open_recording(path)
    assert recording.is_complete
    assert recording.duration >= 0.3
    assert json.loads(capsys.readouterr().out)["file"] == str(path)


def test_log_prints_events_and_requests(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["log", str(file)]) == OK
    lines = capsys.readouterr().out.splitlines()
    texts = [line.split("s  ", 1)[1] for line in lines]
    assert texts[0].startswith("request  move_joints {")
    assert "info     eff_joint_traj_controller: goal succeeded" in texts
    assert "warning  emergency stop engaged" in texts
    times = [float(line.split()[0]) for line in lines]
    assert times == sorted(times)


def test_log_as_json_is_one_object(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["log", str(file), "--json"]) == OK
    found = json.loads(capsys.readouterr().out)
    assert found["is_complete"]
    first, *rest = found["entries"]
    assert (first["method"], first["error"]) == ("move_joints", None)
    assert "goal_succeeded" in [entry.get("kind") for entry in rest]
    assert found["duration"] >= max(entry["time"] for entry in rest)


def test_log_prints_warnings_only(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["log", str(file), "--severity", "warning", "--no-requests"]) == OK
    (line,) = capsys.readouterr().out.splitlines()
    assert line.endswith("warning  emergency stop engaged")


def test_export_writes_csv(file: Path, tmp_path: Path) -> None:
    target = tmp_path / "motion.csv"
    assert main(["export", str(file), "--output", str(target)]) == OK
    with target.open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    recording = tool0.open_recording(file)
    elbow = recording.joint_names.index(ELBOW)
    assert [float(row["time"]) for row in rows] == recording.time.tolist()
    assert [float(row[f"{ELBOW}.position"]) for row in rows] == (
        recording.position[:, elbow].tolist()
    )


def test_export_writes_parquet(file: Path, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is missing")
    target = tmp_path / "motion.parquet"
    assert main(["export", str(file), "--output", str(target)]) == OK
    table = parquet.read_table(target)
    recording = tool0.open_recording(file)
    elbow = recording.joint_names.index(ELBOW)
    np.testing.assert_array_equal(
        table[f"{ELBOW}.effort"].to_numpy(), recording.effort[:, elbow]
    )


def test_export_overwrites_nothing(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "mine.csv"
    target.write_text("mine", encoding="utf-8")
    assert main(["export", str(file), "--output", str(target)]) == FAILED
    assert target.read_text(encoding="utf-8") == "mine"
    assert "exists already" in capsys.readouterr().err


def test_a_file_that_is_no_recording_is_an_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "notes.txt"
    file.write_text("notes", encoding="utf-8")
    assert main(["log", str(file)]) == FAILED
    assert "is no MCAP file" in capsys.readouterr().err
