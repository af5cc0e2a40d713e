"""A simulated run beside a recording: the same requests, and how the motions differ."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tool0
from tool0.recording.reading import open_recording
from tool0.recording.signals import Signals
from tool0.recording.simulated_run import simulate_beside
from tool0.simulation.config import SimulationConfig

PAN, ELBOW = "shoulder_pan_joint", "elbow_joint"


def recorded(
    folder: Path, session: Callable[[tool0.Robot], None], **options: Any
) -> Path:
    file = folder / "session.mcap"
    simulation = SimulationConfig(record=file, realtime=False)
    with tool0.bringup(arm="ur5e", simulation=simulation, **options) as robot:
        session(robot)
    return file


def moves(robot: tool0.Robot) -> None:
    (goal,) = robot.move_joints({ELBOW: 2.0, PAN: 0.4}, speed=1.0)
    goal.wait()
    robot.gripper.move(opening=0.02)
    robot.run(0.5)


def test_the_same_physics_does_the_same(tmp_path: Path) -> None:
    file = recorded(tmp_path, moves)
    run, recording = simulate_beside(file), open_recording(file)
    np.testing.assert_array_equal(run.position, recording.position)
    np.testing.assert_array_equal(run.effort, recording.effort)
    assert (run.lag, run.notes) == (0.0, ())
    assert run.joints[ELBOW].position_most == 0.0
    assert run.joints[ELBOW].recorded_effort > 1.0
    assert "left_inner_finger_joint" not in run.joints  # it follows another one
    signals = Signals(recording, run)
    np.testing.assert_array_equal(
        signals[f"joint/{ELBOW}/simulated"], signals[f"joint/{ELBOW}/position"]
    )
    assert f"joint/{ELBOW}/simulated" not in list(Signals(recording))


@pytest.mark.slow
def test_what_nobody_requested_is_not_repeated(tmp_path: Path) -> None:
    """As a stop on the pendant; but the slider is followed."""

    def session(robot: tool0.Robot) -> None:
        simulation = robot.simulation
        arm = simulation.core.arms.find(None)
        simulation.loop.call(lambda: arm.box.set_speed_slider(0.5))
        robot.run(0.5)
        robot.move_joints({PAN: 1.0}, speed=1.0)
        robot.run(0.6)
        simulation.loop.call(lambda: arm.stop(simulation.core.state))
        robot.run(3.0)

    file = recorded(tmp_path, session, ros2_control=True)
    run, recording = simulate_beside(file), open_recording(file)
    assert recording.position[-1, 0] < 0.4
    assert run.position[-1, 0] > 0.95
    assert run.joints[PAN].position_most > 0.5
    assert run.joints[ELBOW].position_most < 0.01
    speeds = np.diff(run.position[:, 0]) / np.diff(recording.time)
    assert speeds.max() == pytest.approx(1.16, abs=0.05)  # 2.3 with the whole slider


def test_a_robot_that_follows_late_is_compared_without_its_lag(tmp_path: Path) -> None:
    file = recorded(tmp_path, moves)
    recording = open_recording(file)
    run = simulate_beside(file)
    late = np.interp(recording.time - 0.06, recording.time, run.position[:, 0])
    recording.position[:, 0] = late
    for k in (1, 2):
        at = recording.time - 0.06
        recording.position[:, k] = np.interp(at, recording.time, run.position[:, k])
    again = simulate_beside(recording)
    assert again.lag == pytest.approx(0.06, abs=0.004)
    assert again.joints[PAN].position_most < 2e-3
    assert np.abs(recording.position[:, 0] - run.position[:, 0]).max() > 0.03
