"""The file of a person's poses: nothing in it gets lost."""

import multiprocessing
import threading
from pathlib import Path

import pytest
from tool0.runtime.saved_poses import SavedPoses, poses_file

from tool0.errors import ConfigError

POSE = {"elbow_joint": 1.5708, "wrist_1_joint": -1e-05}


@pytest.fixture
def poses(data_home: Path) -> SavedPoses:
    return SavedPoses(poses_file("ur5"))


def write(poses: SavedPoses, text: str) -> None:
    poses.file.parent.mkdir(parents=True, exist_ok=True)
    poses.file.write_text(text, encoding="utf-8")


def save_many(file: Path, who: str) -> None:
    for number in range(20):
        SavedPoses(file).save(f"{who} {number}", POSE)


def test_the_file_is_where_a_desktop_keeps_data(
    data_home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert poses_file("ur5") == data_home / "tool0" / "poses" / "ur5.yaml"
    home = Path.home() / ".local" / "share"
    for relative in ("", "data"):
        monkeypatch.setenv("XDG_DATA_HOME", relative)
        assert poses_file("ur5") == home / "tool0" / "poses" / "ur5.yaml"


def test_no_robot_s_name_leads_out_of_the_folder() -> None:
    folder = poses_file("ur5").parent
    for name in ("../../etc/x", "a/b", "..", "机器人", "my arm"):
        assert poses_file(name).parent == folder


def test_there_are_none_at_first_and_reading_makes_no_file(poses: SavedPoses) -> None:
    assert poses.read() == {}
    assert not poses.file.parent.exists()


@pytest.mark.parametrize(
    "name", ["over the box", "on", "1", "a/b", "取料", "a: b", "~"]
)
def test_what_is_saved_is_read_to_the_bit_by_everybody(
    poses: SavedPoses, name: str
) -> None:
    poses.save("first", {})
    poses.save(name, POSE)
    assert poses.read() == SavedPoses(poses.file).read() == {"first": {}, name: POSE}
    poses.delete("first")
    poses.delete("first")
    assert SavedPoses(poses.file).read() == {name: POSE}


def test_what_another_process_saves_is_seen(poses: SavedPoses) -> None:
    poses.save("a", POSE)
    assert list(poses.read()) == ["a"]
    SavedPoses(poses.file).save("b", POSE)
    assert list(poses.read()) == ["a", "b"]


@pytest.mark.slow
def test_two_processes_and_two_threads_at_once_lose_nothing(poses: SavedPoses) -> None:
    context = multiprocessing.get_context("spawn")
    workers = [
        kind(target=save_many, args=(poses.file, f"{kind.__name__} {number}"))
        for kind in (context.Process, threading.Thread)
        for number in range(2)
    ]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert len(poses.read()) == 80
    left = {item.name for item in poses.file.parent.iterdir()}
    assert left == {"ur5.yaml", "ur5.lock"}


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("home: {elbow_joint: 1\n", 2, "not YAML"),
        ("a: {}\nb: [1]\n", 2, "pose 'b' must be a mapping"),
        ("a:\n  elbow_joint: far\n", 2, "'elbow_joint' of pose 'a' must be a finite"),
        ("a:\n  elbow_joint: .inf\n", 2, "must be a finite number, got '.inf'"),
        ("a:\n  elbow_joint: {x: 1}\n", 2, "must be a finite number"),
        ("a: {}\nb: {}\na: {}\n", 3, "has 'a' twice"),
        ("- a\n", 1, "the file must be a mapping"),
        ("? [a]\n: {}\n", 1, "a key that is no name"),
    ],
)
def test_a_broken_file_is_told_by_line_and_left_alone(
    poses: SavedPoses, text: str, line: int, message: str
) -> None:
    write(poses, text)
    for change in (
        poses.read,
        lambda: poses.save("new", POSE),
        lambda: poses.delete("a"),
    ):
        with pytest.raises(ConfigError, match=message) as error:
            change()
        assert error.value.location.file == poses.file
        assert error.value.location.line == line
    assert poses.file.read_text(encoding="utf-8") == text


def test_a_file_that_is_no_text_is_told(poses: SavedPoses) -> None:
    write(poses, "")
    assert poses.read() == {}
    poses.file.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ConfigError, match="not YAML"):
        poses.read()


def test_a_folder_that_cannot_be_is_told(poses: SavedPoses) -> None:
    poses.file.parent.parent.mkdir(parents=True)
    poses.file.parent.write_text("in the way")
    with pytest.raises(ConfigError, match="cannot write the saved poses"):
        poses.save("a", POSE)
