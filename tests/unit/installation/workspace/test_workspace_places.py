"""Packages go where catkin's users expect them."""

from pathlib import Path

import pytest

from tool0.errors import ConfigError
from tool0.installation.workspace.places import source_folder


def make_package(folder: Path, name: str = "") -> Path:
    folder.mkdir(parents=True)
    text = f"<package><name>{name or folder.name}</name></package>"
    (folder / "package.xml").write_text(text)
    return folder


def test_a_new_or_empty_folder_becomes_a_workspace(tmp_path: Path) -> None:
    assert source_folder(tmp_path / "new") == tmp_path / "new" / "src"
    assert source_folder(tmp_path) == tmp_path / "src"


def test_a_workspace_has_them_in_src(tmp_path: Path) -> None:
    make_package(tmp_path / "src" / "robotiq" / "robotiq_description")
    (tmp_path / "devel").mkdir()
    assert source_folder(tmp_path) == tmp_path / "src"


def test_a_folder_of_packages_is_taken_itself(tmp_path: Path) -> None:
    make_package(tmp_path / "my_robot")
    assert source_folder(tmp_path) == tmp_path
    assert source_folder(tmp_path / "ws" / "src") == tmp_path / "ws" / "src"


def test_the_toplevel_of_catkin_marks_a_folder_of_packages(tmp_path: Path) -> None:
    toplevel = tmp_path / "toplevel.cmake"
    toplevel.touch()
    folder = tmp_path / "packages"
    folder.mkdir()
    (folder / "CMakeLists.txt").symlink_to(toplevel)
    assert source_folder(folder) == folder


def test_a_relative_path_counts_from_here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert source_folder(Path("ws")) == tmp_path / "ws" / "src"
    assert source_folder(Path("~/ws")) == tmp_path / "home" / "ws" / "src"


def test_a_file_is_no_workspace(tmp_path: Path) -> None:
    (tmp_path / "src").write_text("not a folder")
    for folder in (tmp_path / "src", tmp_path, tmp_path / "src" / "deeper"):
        with pytest.raises(ConfigError, match="is not a folder"):
            source_folder(folder)


def test_a_link_to_nothing_is_told(tmp_path: Path) -> None:
    (tmp_path / "ws").symlink_to(tmp_path / "gone")
    with pytest.raises(ConfigError, match="link to nothing"):
        source_folder(tmp_path / "ws")


def test_the_inside_of_a_package_is_refused(tmp_path: Path) -> None:
    package = make_package(tmp_path / "src" / "my_robot")
    for folder in (package, package / "src"):
        with pytest.raises(ConfigError, match="looks for none inside"):
            source_folder(folder)


def test_a_package_of_the_same_name_elsewhere_is_told(tmp_path: Path) -> None:
    other = make_package(tmp_path / "src" / "copy", "tool0_gazebo")
    with pytest.raises(ConfigError, match=r"src/copy' is a package called tool0_gaz"):
        source_folder(tmp_path)
    (other / "CATKIN_IGNORE").touch()
    assert source_folder(tmp_path) == tmp_path / "src"


def test_a_linked_package_is_not_written_through(tmp_path: Path) -> None:
    real = make_package(tmp_path / "elsewhere" / "tool0_description")
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "tool0_description").symlink_to(real)
    with pytest.raises(ConfigError, match="is a link to"):
        source_folder(tmp_path)
