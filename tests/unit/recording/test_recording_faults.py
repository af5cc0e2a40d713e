"""What goes wrong: killed processes, full disks, files that are no recordings."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from recording_session import Session

import tool0

LOSS = 1.0
"""What kill -9 may lose [s]."""
N_KILLS = 20

BRINGUP = """
import sys, tool0
with tool0.bringup(gripper=None, record=sys.argv[1]) as robot:
    subscription = robot.subscribe()
    while True:
        snapshot = subscription.next()
        print(snapshot.time, flush=True)
"""
"""Prints every time that was published, until it is killed."""


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False, gripper=None) as robot:
        yield robot


@pytest.mark.slow
def test_kill_9_loses_at_most_a_second(tmp_path: Path) -> None:
    """At twenty instants: real kills of some processes, and their files before."""
    files, ends = grow_and_kill(tmp_path, n_processes=2, n_instants=N_KILLS)
    assert len(files) == N_KILLS
    for file, published in zip(files, ends, strict=True):
        recording = tool0.open_recording(file)
        assert not recording.is_complete
        last = recording.time[-1] if len(recording) else 0.0
        assert last >= published - LOSS, file


def grow_and_kill(
    folder: Path, *, n_processes: int, n_instants: int
) -> tuple[list[Path], list[float]]:
    """Return files that were cut off, and the time published when each was."""
    paths = [folder / f"{number}.mcap" for number in range(n_processes)]
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", BRINGUP, str(path)],
            stdout=subprocess.PIPE,
            text=True,
        )
        for path in paths
    ]
    files, ends = [], []
    try:
        each = n_instants // n_processes
        for number in range(each):
            for process, path in zip(processes, paths, strict=True):
                published = read_until(process, 0.4 + 0.17 * number)
                if number < each - 1:  # a file now is what a kill would leave
                    copy = path.with_name(f"{path.stem}-{number}.mcap")
                    copy.write_bytes(path.read_bytes())
                    files.append(copy)
                else:
                    process.send_signal(signal.SIGKILL)
                    files.append(path)
                ends.append(published)
    finally:
        for process in processes:
            process.kill()
            process.communicate()
    return files, ends


def read_until(process: subprocess.Popen[str], end: float) -> float:
    """Return the first published time of at least ``end`` [s]."""
    assert process.stdout is not None
    for line in process.stdout:
        if (published := float(line)) >= end:
            return published
    raise AssertionError("the process has ended")


@pytest.mark.slow
def test_a_full_disk_ends_the_recording_and_not_the_simulation(
    robot: tool0.Robot, tmp_path: Path
) -> None:
    file = tmp_path / "full.mcap"
    robot.start_recording(file)
    subscription = robot.subscribe()
    robot.run(0.1)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    size = file.stat().st_size
    try:  # a file that cannot grow: the write fails as on a full disk
        resource.setrlimit(resource.RLIMIT_FSIZE, (size + 200_000, before[1]))
        status = ended(robot)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, ignored)
    assert status.error == f"{file}: File too large"
    start = robot.time
    robot.run(0.1)
    assert robot.time == pytest.approx(start + 0.1)
    (report,) = subscription.events
    assert status.error in str(report)
    recording = tool0.open_recording(file)
    assert not recording.is_complete
    assert len(recording) > 0
    assert file.stat().st_size <= size + 200_000
    robot.start_recording(tmp_path / "next.mcap")  # when there is room again
    assert robot.stop_recording().error is None


def ended(robot: tool0.Robot) -> tool0.RecordingStatus:
    """Let time pass until the recording has ended by itself."""
    for _ in range(2000):
        robot.run(0.1)
        status = robot.recording
        assert status is not None
        if not status.is_recording:
            return status
        time.sleep(0.0)
    raise AssertionError("the recording goes on")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="Linux only")
def test_a_disk_that_is_full_from_the_start_is_reported(
    robot: tool0.Robot, tmp_path: Path
) -> None:
    file = tmp_path / "full.mcap"
    file.symlink_to("/dev/full")
    with pytest.raises(tool0.RecordingError, match="No space left on device"):
        robot.start_recording(file, overwrite=True)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_read_only_folder_is_reported(robot: tool0.Robot, tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(tool0.RecordingError, match="Permission denied"):
        robot.start_recording(tmp_path / "new.mcap")


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("missing/new.mcap", "No such file or directory"),
        ("file/new.mcap", "Not a directory"),
        ("\0.mcap", "null"),
        ("x" * 300 + ".mcap", "File name too long"),
        ("new.bag", "ends in .mcap, got 'new.bag'; write 'new.mcap'"),
        ("there.mcap", "exists already"),
    ],
)
def test_a_file_that_cannot_be_written_is_reported(
    robot: tool0.Robot, tmp_path: Path, name: str, problem: str
) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "there.mcap").touch()
    with pytest.raises(tool0.RecordingError, match=problem):
        robot.start_recording(tmp_path / name)
    assert robot.recording is None


def test_a_recording_from_the_start_replaces_a_file_if_it_may(tmp_path: Path) -> None:
    file = tmp_path / "there.mcap"
    file.touch()
    once = tool0.SimulationConfig(record=file, realtime=False)
    with pytest.raises(tool0.RecordingError, match="exists already"):
        tool0.bringup(gripper=None, simulation=once)
    with tool0.bringup(gripper=None, simulation=replace(once, overwrite=True)) as robot:
        robot.run(0.1)
    assert tool0.open_recording(file).duration == pytest.approx(0.1, abs=0.01)


def test_a_second_recording_is_refused(robot: tool0.Robot, tmp_path: Path) -> None:
    robot.start_recording(tmp_path / "one.mcap")
    with pytest.raises(tool0.ControlError, match=r"one\.mcap is in progress"):
        robot.start_recording(tmp_path / "two.mcap")
    assert not (tmp_path / "two.mcap").exists()


def test_stopping_nothing_is_refused(robot: tool0.Robot) -> None:
    with pytest.raises(tool0.ControlError, match="nothing is recorded"):
        robot.stop_recording()


def test_a_camera_that_does_not_exist_is_refused(
    robot: tool0.Robot, tmp_path: Path
) -> None:
    with pytest.raises(tool0.RenderError, match="no camera 'wrong'"):
        robot.start_recording(tmp_path / "new.mcap", cameras=["wrong"])
    assert not (tmp_path / "new.mcap").exists()


def test_a_truncated_file_is_read_up_to_its_last_whole_chunk(
    session: Session, tmp_path: Path
) -> None:
    """Wherever it was cut: more bytes never mean fewer snapshots."""
    data = session.path.read_bytes()
    whole = tool0.open_recording(session.path)
    first = data.index(b"controllers.yaml")  # the robot is complete then
    file = tmp_path / "cut.mcap"
    counts = []
    for size in range(first + 20_000, len(data), 30_011):
        file.write_bytes(data[:size])
        recording = tool0.open_recording(file)
        assert not recording.is_complete
        n = len(recording)
        assert recording.position.tolist() == whole.position[:n].tolist()
        counts.append(n)
    assert counts == sorted(counts)
    assert counts[-1] > 0


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"", "is empty"),
        (b"#ROSBAG V2.0\n" + bytes(100), "is no MCAP file"),
        (b"\x89MCAP0\r\n", "no recording of tool0"),
        (b"\x89MCAP0\r\n" + b"\x01\xff" + bytes(30), "no recording of tool0"),
    ],
)
def test_another_file_is_reported(tmp_path: Path, content: bytes, problem: str) -> None:
    file = tmp_path / "other.mcap"
    file.write_bytes(content)
    with pytest.raises(tool0.RecordingError, match=problem):
        tool0.open_recording(file)


def test_a_missing_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(tool0.RecordingError, match="No such file"):
        tool0.open_recording(tmp_path / "none.mcap")


def test_a_recording_of_another_program_is_reported(tmp_path: Path) -> None:
    from mcap.writer import Writer

    file = tmp_path / "foreign.mcap"
    with file.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        writer.finish()  # type: ignore[no-untyped-call]
    with pytest.raises(tool0.RecordingError, match="no recording of tool0"):
        tool0.open_recording(file)


def test_a_damaged_file_is_reported(session: Session, tmp_path: Path) -> None:
    data = bytearray(session.path.read_bytes())
    at = len(data) - 60_000  # within a chunk, after the attachments
    data[at : at + 100] = bytes(100)
    file = tmp_path / "damaged.mcap"
    file.write_bytes(data)
    with pytest.raises(tool0.RecordingError, match=r"damaged at byte \d+"):
        tool0.open_recording(file)


def test_a_newer_format_is_reported(session: Session, tmp_path: Path) -> None:
    data = session.path.read_bytes()
    file = tmp_path / "newer.mcap"
    old = b"\x06\x00\x00\x00format\x01\x00\x00\x001"
    assert old in data
    cut = data[: len(data) // 2]  # without the checksum of the file
    file.write_bytes(cut.replace(old, old[:-1] + b"9"))
    with pytest.raises(tool0.RecordingError, match="has format 9"):
        tool0.open_recording(file)
