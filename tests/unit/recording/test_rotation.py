"""Recordings that go on in another file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import tool0


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False, gripper=None) as robot:
        yield robot


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_after_a_duration(robot: tool0.Robot, tmp_path: Path) -> None:
    robot.start_recording(tmp_path / "a.mcap", max_duration=1.0)
    robot.move_joints({"elbow_joint": 1.0})
    robot.run(2.5)
    status = robot.stop_recording()
    assert names(tmp_path) == ["a.mcap", "a_2.mcap", "a_3.mcap"]
    assert status.files == 3
    assert status.file == str(tmp_path / "a_3.mcap")
    assert status.size == sum(path.stat().st_size for path in tmp_path.iterdir())
    parts = [tool0.open_recording(tmp_path / name) for name in names(tmp_path)]
    assert all(part.is_complete for part in parts)
    times = np.concatenate([part.time for part in parts])
    np.testing.assert_allclose(np.diff(times), 0.008)
    assert [part.info.part for part in parts] == [1, 2, 3]
    for part in parts:  # each can be repeated, and shows the robot
        assert [item.method for item in part.requests] == ["move_joints"]
        assert len(part.description.model.links) > 6


@pytest.mark.slow
def test_after_a_size(robot: tool0.Robot, tmp_path: Path) -> None:
    robot.start_recording(tmp_path / "a.mcap", max_size=1_000_000)
    for position in (1.0, 1.6, 1.0, 1.6):
        robot.move_joints({"elbow_joint": position})
        robot.run(8.0)
        if len(names(tmp_path)) > 1:
            break
    robot.stop_recording()
    assert len(names(tmp_path)) > 1
    assert (tmp_path / "a.mcap").stat().st_size < 1_500_000


def test_a_reset_begins_another_file(robot: tool0.Robot, tmp_path: Path) -> None:
    robot.start_recording(tmp_path / "a.mcap")
    robot.run(0.5)
    robot.reset()
    robot.run(0.3)
    robot.stop_recording()
    first, second = (tool0.open_recording(tmp_path / name) for name in names(tmp_path))
    assert first.time[-1] == pytest.approx(0.496, abs=0.005)
    assert second.time[0] == 0.0
    assert second.time[-1] == pytest.approx(0.3, abs=0.008)
    assert [event.kind for event in second.events] == ["reset"]
    assert not first.events


def test_time_that_goes_on_after_a_reset_stays_in_the_file(
    robot: tool0.Robot, tmp_path: Path
) -> None:
    robot.start_recording(tmp_path / "a.mcap")
    robot.run(0.5)
    robot.reset(keep_time=True)
    robot.run(0.3)
    robot.stop_recording()
    (only,) = (tool0.open_recording(tmp_path / name) for name in names(tmp_path))
    assert [event.kind for event in only.events] == ["reset"]
    assert only.duration == pytest.approx(0.8, abs=0.008)


def test_only_the_newest_files_are_kept(robot: tool0.Robot, tmp_path: Path) -> None:
    robot.start_recording(tmp_path / "a.mcap", max_duration=1.0, max_files=2)
    robot.run(3.5)
    status = robot.stop_recording()
    assert status.files == 4
    assert names(tmp_path) == ["a_3.mcap", "a_4.mcap"]


@pytest.mark.slow
def test_without_real_time_nothing_is_dropped(
    robot: tool0.Robot, tmp_path: Path
) -> None:
    robot.start_recording(tmp_path / "a.mcap")
    robot.run(30.0)  # more snapshots than may wait
    assert robot.stop_recording().dropped == 0
    times = tool0.open_recording(tmp_path / "a.mcap").time
    np.testing.assert_allclose(np.diff(times), 0.008)
    assert len(times) == 3751
