"""A workspace gets the files that tool0 reads, where catkin's users expect them."""

from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

import pytest

from tool0.description.packages import BUNDLED
from tool0.errors import ConfigError
from tool0.installation.workspace.layout import (
    PACKAGES,
    UPSTREAM_PACKAGES,
    package_files,
    source_folder,
)

MESHES_ARGUMENT = (
    "tool0_description/launch/view_ur5_robotiq_2f_85.launch",
    "tool0_description/urdf/ur_robotiq.urdf.xacro",
    "tool0_gazebo/launch/inc/load_ur5_robotiq_2f_85.launch.xml",
    "tool0_gazebo/launch/ur5_robotiq_2f_85_bringup.launch",
)


def test_it_is_what_the_program_reads() -> None:
    files = package_files()
    assert {path.parts[0] for path in files} == set(PACKAGES)
    assert all((BUNDLED / path).read_bytes() == data for path, data in files.items())
    for needed in ("package.xml", "CMakeLists.txt"):
        assert all(PurePosixPath(name, needed) in files for name in PACKAGES)


def test_what_tools_leave_behind_stays_out() -> None:
    names = [part for path in package_files() for part in path.parts]
    assert not [name for name in names if name.startswith((".", "__"))]


def test_upstream_meshes_change_the_default_and_the_dependencies_alone() -> None:
    ours, theirs = package_files(), package_files(upstream_meshes=True)
    changed = {str(path) for path in ours if ours[path] != theirs[path]}
    assert changed == {*MESHES_ARGUMENT, "tool0_description/package.xml"}
    for name in MESHES_ARGUMENT:
        path = PurePosixPath(name)
        assert theirs[path].count(b'"meshes" default="upstream"') == 1
        assert b'"meshes" default="tool0"' not in theirs[path]


def test_upstream_packages_become_dependencies() -> None:
    path = PurePosixPath("tool0_description/package.xml")

    def dependencies(data: bytes) -> set[str | None]:
        found = ElementTree.fromstring(data.decode()).iterfind("exec_depend")
        return {element.text for element in found}

    added = dependencies(package_files(upstream_meshes=True)[path])
    assert added - dependencies(package_files()[path]) == set(UPSTREAM_PACKAGES)


# --- the folder ---


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
        with pytest.raises(ConfigError):
            source_folder(folder)


def test_a_link_to_nothing_is_told(tmp_path: Path) -> None:
    (tmp_path / "ws").symlink_to(tmp_path / "gone")
    with pytest.raises(ConfigError):
        source_folder(tmp_path / "ws")


def test_the_inside_of_a_package_is_refused(tmp_path: Path) -> None:
    package = make_package(tmp_path / "src" / "my_robot")
    for folder in (package, package / "src"):
        with pytest.raises(ConfigError):
            source_folder(folder)


def test_a_package_of_the_same_name_elsewhere_is_told(tmp_path: Path) -> None:
    other = make_package(tmp_path / "src" / "copy", "tool0_gazebo")
    with pytest.raises(ConfigError) as error:
        source_folder(tmp_path)
    assert str(other) in str(error.value)
    assert "tool0_gazebo" in str(error.value)
    (other / "CATKIN_IGNORE").touch()
    assert source_folder(tmp_path) == tmp_path / "src"


def test_a_linked_package_is_not_written_through(tmp_path: Path) -> None:
    real = make_package(tmp_path / "elsewhere" / "tool0_description")
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "tool0_description").symlink_to(real)
    with pytest.raises(ConfigError):
        source_folder(tmp_path)
