"""Policies on a robot that has been brought up."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import policies_for_tests
import pyarrow.parquet as pq
import pytest
from promised import require_gl
from raises_naming import raises_naming

import tool0
from tool0.errors import ControlError
from tool0.policy import RunOptions, execute

HERE = Path(__file__).parent / "policies_for_tests.py"


def policy(name: str) -> str:
    return f"{HERE}:{name}"


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False) as found:
        yield found


@pytest.mark.slow
def test_it_follows_the_actions_and_gives_the_arm_back(
    robot: tool0.Robot, tmp_path: Path
) -> None:
    folder = tmp_path / "run"
    run = RunOptions(max_steps=50)
    found = execute(policy("Wave"), robot, run=run, folder=folder)
    assert (found.result, found.n_steps, found.n_held) == ("ended", 50, 0)
    assert 2.0 <= robot.time < 2.5  # with the time that the arm takes to stop
    assert found.episode is not None
    position = found.episode.observations["position"]
    error = position[2:, 4] - found.episode.actions[:-2, 4]  # a lag of a period
    assert np.sqrt(np.mean(error**2)) < 0.006
    assert np.ptp(position[:, 4]) > 0.35
    assert np.ptp(position[:, :4], axis=0).max() < 0.01
    assert position[-1, 6] > 0.4
    robot.move_joints({"elbow_joint": 1.0})[0].wait()  # the controllers have it again
    assert json.loads((folder / "report.json").read_text())["rate"] == 25.0
    assert len(tool0.open_recording(folder / "recording.mcap")) > 100
    names = pq.read_table(folder / "data/episode_000000.parquet").column_names
    assert {"observation.position", "observation.velocity", "action"} <= set(names)


def test_it_sees_images_which_only_the_recording_keeps(
    robot: tool0.Robot, tmp_path: Path
) -> None:
    require_gl()
    run, folder = RunOptions(max_steps=2), tmp_path / "run"
    found = execute(policy("Looking"), robot, cameras=["wrist"], run=run, folder=folder)
    assert found.episode is not None
    assert set(found.episode.observations) == {"position", "velocity"}
    recording = tool0.open_recording(folder / "recording.mcap")
    assert "wrist" in {camera.name for camera in recording.bringup.cameras}


def test_a_jump_is_refused_before_anything_moves(robot: tool0.Robot) -> None:
    before = robot.joint_state.position
    found = execute(policy("Jump"), robot, run=RunOptions(max_steps=50))
    assert (found.result, found.n_steps) == ("stopped", 0)
    assert "'shoulder_pan_joint'" in found.reason
    assert "at most 0.113 rad are allowed" in found.reason
    robot.run(0.2)
    assert robot.joint_state.position == pytest.approx(before, abs=5e-3)


def test_an_emergency_stop_ends_it_and_nothing_moves_again(robot: tool0.Robot) -> None:
    n = 0

    def should_stop() -> bool:
        nonlocal n
        n += 1
        if n == 10:
            robot.emergency_stop()
        return False

    run = RunOptions(max_steps=50)
    with raises_naming(ControlError, "emergency stop"):
        execute(policy("Wave"), robot, run=run, should_stop=should_stop)
    robot.emergency_stop(engaged=False)
    robot.run(0.3)
    before = robot.joint_state.position
    robot.run(0.5)
    assert robot.joint_state.position == pytest.approx(before, abs=5e-3)


@pytest.mark.slow
def test_time_passes_while_a_policy_computes(tmp_path: Path) -> None:
    policies_for_tests.is_answered.clear()
    is_holding = threading.Event()
    with tool0.bringup(speed=5.0) as robot:
        seen = 0

        def should_stop() -> bool:
            nonlocal seen
            seen += 1
            if robot.time > 1.0:  # the first chunk was over at 0.4 s
                is_holding.set()
                policies_for_tests.is_answered.set()
            return False

        found = execute(
            "policies_for_tests:Waiting",
            robot,
            run=RunOptions(max_steps=50),
            should_stop=should_stop,
        )
    assert found.reason == ""
    assert found.result == "ended"
    assert is_holding.is_set()
    assert found.n_held >= 10
    assert max(found.latencies) > 0.05
    assert found.episode is not None
    held = np.diff(found.episode.actions[14:20], axis=0)
    assert not held.any()  # the last target, again and again
