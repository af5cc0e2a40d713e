"""``tool0 record --episodes``: keys drive the robot and mark episodes."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import tool0
from tool0.cli.connection import Bringup
from tool0.cli.episodes import record_episodes


def test_keys_drive_the_robot_and_mark_episodes(
    robot: tool0.Robot,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    from tool0.protocol.episodes import ReadEpisodes
    from tool0.recording.episodes import read_index
    from tool0.recording.reading import open_recording

    folder = tmp_path / "push"
    reading, writing = os.pipe()
    os.write(writing, b" wcy xnq")
    with os.fdopen(reading) as keys:
        monkeypatch.setattr("sys.stdin", keys)
        assert record_episodes(folder, "push", reset=True, bringup=Bringup()) == 0
    os.close(writing)
    (row,) = read_index(folder)
    assert (row.outcome, row.task) == ("success", "push")
    recording = open_recording(folder / row.file)
    methods = [request.method for request in recording.requests]
    assert {"take_arm", "speed_tool", "follow_trajectory"} <= set(methods)
    out = capsys.readouterr().out
    assert "1 episode, 1 succeeded\n" in out
    assert "no episode is being recorded" in out  # of the key n
    assert robot.channel.call(ReadEpisodes()) is None
    box = robot.arm.control_box  # is released when the connection ends
    assert robot.channel.wait_until(lambda: box.state.taken_by == "", timeout=10.0)
