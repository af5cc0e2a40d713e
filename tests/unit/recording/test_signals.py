"""Signals of a recording, by the names of the panel's plots."""

import math
from pathlib import Path

import numpy as np
import pytest
from recorded_session import record_session

from tool0.description.forward_kinematics import link_pose
from tool0.description.transform import Pose, to_transform
from tool0.errors import RecordingError
from tool0.recording.reading import RecordingFile, open_recording
from tool0.recording.signals import Signals, thinned


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> RecordingFile:
    file: Path = tmp_path_factory.mktemp("recording") / "session.mcap"
    record_session(file)
    return open_recording(file)


@pytest.fixture(scope="module")
def signals(recording: RecordingFile) -> Signals:
    return Signals(recording)


@pytest.mark.slow
def test_joints_are_columns(signals: Signals, recording: RecordingFile) -> None:
    elbow = recording.joint_names.index("elbow_joint")
    np.testing.assert_array_equal(
        signals["joint/elbow_joint/position"], recording.position[:, elbow]
    )
    np.testing.assert_array_equal(
        signals["joint/elbow_joint/error"],
        recording.desired_position[:, elbow] - recording.position[:, elbow],
    )


@pytest.mark.parametrize("index", [0, 77, -1])
def test_the_tool_is_where_forward_kinematics_say(
    signals: Signals, recording: RecordingFile, index: int
) -> None:
    snapshot = recording.snapshots()[index]
    pose = link_pose(recording.description.model, snapshot.positions, "tool0")
    found = [signals[f"tool/arm/{part}"][index] for part in ("x", "y", "z")]
    np.testing.assert_allclose(found, pose.position, atol=1e-9)
    rpy = tuple(float(signals[f"tool/arm/{p}"][index]) for p in _ANGLES)
    turned = to_transform(_pose(rpy))
    np.testing.assert_allclose(turned.rotation, pose.rotation, atol=1e-9)


def test_an_object_has_no_place_before_it_is_added(signals: Signals) -> None:
    heights = signals["object/box/z"]
    assert math.isnan(heights[0])
    assert heights[-1] == pytest.approx(-0.05, abs=2e-3)  # on the ground
    assert signals["object/box/yaw"][-1] == pytest.approx(0.0, abs=1e-2)


def test_every_signal_has_a_value_for_each_snapshot(
    signals: Signals, recording: RecordingFile
) -> None:
    assert len(signals) == len(list(signals))
    for name in signals:
        assert signals[name].shape == (len(recording),), name


def test_an_unknown_signal_is_refused(signals: Signals) -> None:
    with pytest.raises(RecordingError, match="did you mean"):
        signals["joint/elbow_joint/positions"]


def test_thinning_keeps_the_peaks() -> None:
    time = np.arange(1000) * 0.008
    values = np.sin(time)
    values[123], values[877] = 9.0, -9.0
    values[500:600] = np.nan
    times, (found,) = thinned(time, [values], 100)
    assert len(times) == len(found) <= 102
    assert times == sorted(times)
    known = [value for value in found if value is not None]
    assert (max(known), min(known)) == (9.0, -9.0)
    assert None in found


def test_few_samples_stay_as_they_are() -> None:
    time = np.arange(10) * 0.1
    times, (found,) = thinned(time, [time**2], 100)
    assert times == time.tolist()
    assert found == (time**2).tolist()


_ANGLES = ("roll", "pitch", "yaw")


def _pose(rpy: tuple[float, float, float]) -> Pose:
    return Pose(xyz=(0.0, 0.0, 0.0), rpy=rpy)
