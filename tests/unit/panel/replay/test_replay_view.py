"""A recording as pages show it."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from msgspec import UNSET
from recorded_session import ADDED_AT, TURNED, record_session

import tool0
from tool0.errors import ControlError, RecordingError
from tool0.panel.replay.view import Replay
from tool0.protocol.replay import LoopReplay, SeekReplay
from tool0.protocol.running import Pause, Reset, Resume, SetSpeed, Step
from tool0.recording.reading import RecordingFile, open_recording


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> RecordingFile:
    file = tmp_path_factory.mktemp("recording") / "session.mcap"
    record_session(file)
    return open_recording(file)


@pytest.fixture
def replay(recording: RecordingFile) -> Iterator[Replay]:
    replay = Replay(recording)
    yield replay
    replay.close()


def test_frames_equal_the_recording(replay: Replay, recording: RecordingFile) -> None:
    for index in (0, 1, 100, len(recording) - 1):
        replay.answer(SeekReplay(time=float(recording.time[index])))
        frame = replay.frame()
        assert frame.time == pytest.approx(recording.time[index], abs=1e-6)
        np.testing.assert_allclose(frame.position, recording.position[index], atol=1e-6)
        np.testing.assert_allclose(frame.velocity, recording.velocity[index], atol=1e-6)
        np.testing.assert_allclose(frame.effort, recording.effort[index], atol=1e-6)


def test_the_last_frame_up_to_a_time_is_shown(
    replay: Replay, recording: RecordingFile
) -> None:
    replay.answer(SeekReplay(time=float(recording.time[50]) + 0.004))
    assert replay.frame().time == pytest.approx(recording.time[50], abs=1e-6)
    assert replay.frame() is replay.frame()


def test_the_scene_is_that_of_the_time(replay: Replay) -> None:
    replay.answer(SeekReplay(time=ADDED_AT - 0.1))
    before = replay.frame()
    assert not replay.scene().objects
    replay.answer(SeekReplay(time=1e9))
    after = replay.frame()
    assert [item.name for item in replay.scene().objects] == ["box"]
    assert (len(before.objects), len(after.objects)) == (0, 1)
    assert after.scene_number == replay.scene().number != before.scene_number
    replay.answer(Reset())
    assert replay.frame().scene_number == replay.scene().number
    assert not replay.scene().objects


def test_the_view_tells_what_happened_and_when(replay: Replay) -> None:
    info = replay.info
    assert info.mode == "replay"
    assert info.replay is not None
    assert info.replay.file == "session.mcap"
    assert info.replay.is_complete
    assert info.replay.end - info.replay.start == pytest.approx(2.5, abs=0.1)
    goals = [
        note
        for note in info.notices
        if note.code.startswith("goal_") and note.text.startswith("eff_joint")
    ]
    codes = [note.code for note in goals]
    assert codes == ["goal_succeeded", "goal_preempted"]
    assert goals[0].time == pytest.approx(1.0, abs=0.05)
    assert [note.number for note in info.notices] == list(
        range(1, len(info.notices) + 1)
    )


def test_the_status_is_that_of_the_playhead(replay: Replay) -> None:
    status = replay.status(clients=1)
    assert status.paused
    replay.answer(SetSpeed(factor=0.25))
    replay.answer(LoopReplay(loops=True))
    replay.answer(Resume())
    status = replay.status(clients=1)
    assert (status.paused, status.speed, status.loops) == (False, 0.25, True)
    replay.answer(Pause())
    assert replay.status(clients=1).paused


def test_grippers_are_as_they_were(replay: Replay) -> None:
    replay.answer(SeekReplay(time=1e9))
    (gripper,) = replay.status(clients=1).grippers
    assert gripper.opening == pytest.approx(0.02, abs=1e-3)
    assert gripper.motion == "at_target"


def test_targets_are_as_they_were(replay: Replay) -> None:
    replay.answer(SeekReplay(time=0.5))
    targets = replay.status(clients=1).targets
    assert targets["elbow_joint"] == pytest.approx(TURNED[2])


def test_a_step_goes_on_by_ticks(replay: Replay) -> None:
    replay.answer(SeekReplay(time=0.8))
    assert replay.answer(Step(ticks=100)) == pytest.approx(0.9)


def test_wrenches_are_there_when_asked_for(
    replay: Replay, recording: RecordingFile
) -> None:
    assert replay.frame().wrenches is UNSET
    replay.need_forces(contacts=True, wrenches=True)
    replay.answer(SeekReplay(time=float(recording.time[60])))
    wrenches = replay.frame().wrenches
    np.testing.assert_allclose(
        wrenches["arm"], recording.wrenches["arm"][60], atol=1e-3
    )
    assert replay.frame().contacts is not UNSET


def test_a_recording_cannot_be_moved(replay: Replay) -> None:
    missing = replay.info.missing
    assert not {"resume", "pause", "set_speed", "reset", "step"} & missing.keys()
    assert not {"seek_replay", "loop_replay", "read_replay"} & missing.keys()
    for method in ("go_to_pose", "emergency_stop", "save_pose"):
        assert "only shows what was recorded" in missing[method]


def test_a_running_robot_is_no_replay() -> None:
    with (
        tool0.bringup(realtime=False) as robot,
        pytest.raises(ControlError, match="tool0 replay"),
    ):
        robot.channel.call(SeekReplay(time=1.0))


def test_a_recording_without_snapshots_is_refused(
    recording: RecordingFile, tmp_path: Path
) -> None:
    from mcap.reader import make_reader

    with recording.path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    first = min(chunk.chunk_start_offset for chunk in summary.chunk_indexes)
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(recording.path.read_bytes()[:first])
    with pytest.raises(RecordingError, match="no snapshots to show"):
        Replay(open_recording(cut))
