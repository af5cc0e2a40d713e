from pathlib import Path

import pytest

from tool0.errors import EngineUnavailableError, RosUnavailableError
from tool0.installation.own_folder import exclusive, removed, size_on_disk


def test_only_one_process_changes_a_folder(tmp_path: Path) -> None:
    folder = tmp_path / "own"
    with (
        exclusive(folder, "ROS 2", RosUnavailableError),
        pytest.raises(RosUnavailableError, match="installs or removes ROS 2"),
    ):
        removed(folder, "ROS 2", RosUnavailableError)
    assert folder.is_dir()


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with (
        pytest.raises(EngineUnavailableError, match="cannot write"),
        exclusive(tmp_path / "file", "Gazebo", EngineUnavailableError),
    ):
        pass


def test_a_folder_is_removed_once(tmp_path: Path) -> None:
    folder = tmp_path / "own"
    folder.mkdir()
    (folder / "one").write_bytes(b"x" * 100_000)
    assert removed(folder, "Gazebo", EngineUnavailableError) >= 100_000
    assert removed(folder, "Gazebo", EngineUnavailableError) == 0


def test_a_file_of_two_names_is_counted_once(tmp_path: Path) -> None:
    (tmp_path / "one").write_bytes(b"x" * 100_000)
    once = size_on_disk(tmp_path)
    (tmp_path / "two").hardlink_to(tmp_path / "one")
    assert size_on_disk(tmp_path) == once >= 100_000
