"""Writing twice updates what was written, and leaves a person's edits alone."""

import errno
import os
from pathlib import Path, PurePosixPath

import pytest

from tool0.errors import ConfigError
from tool0.installation.workspace import (
    RECORD_FILE,
    FileAction,
    WorkspaceChanges,
    source_folder,
    write_workspace,
)

LAUNCH = "tool0_gazebo/launch/bringup.launch"
XACRO = "tool0_description/urdf/shapes.xacro"
PACKAGES = ("tool0_description", "tool0_gazebo")
EDIT = "<launch/> <!-- mine -->\n"

Files = dict[PurePosixPath, bytes]


@pytest.fixture
def shipped() -> Files:
    """What is written: a test changes it, as another version of tool0 would."""
    names = (LAUNCH, XACRO, *(f"{name}/package.xml" for name in PACKAGES))
    program = "tool0_gazebo/scripts/program"
    return {PurePosixPath(name): name.encode() for name in (*names, program)}


def one(written: WorkspaceChanges, action: FileAction) -> str:
    (path,) = written.paths(action)
    return path.relative_to(written.source).as_posix()


def everything(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_it_writes_real_files(tmp_path: Path, shipped: Files) -> None:
    written = write_workspace(tmp_path / "ws", shipped)
    assert written.source == tmp_path / "ws" / "src"
    assert len(written.paths(FileAction.ADD)) == len(shipped)
    for path, data in shipped.items():
        assert (written.source / path).read_bytes() == data
        assert not (written.source / path).is_symlink()
    before = everything(tmp_path)
    records = {written.source / name / RECORD_FILE for name in PACKAGES}
    assert before.keys() == {written.source / path for path in shipped} | records
    again = write_workspace(tmp_path / "ws", shipped)
    assert set(again.actions.values()) == {FileAction.LEAVE}
    assert everything(tmp_path) == before


def test_files_are_as_readable_as_any_that_a_person_makes(
    tmp_path: Path, shipped: Files
) -> None:
    before = os.umask(0o027)
    try:
        write_workspace(tmp_path, shipped)
    finally:
        os.umask(before)
    assert (tmp_path / "src" / LAUNCH).stat().st_mode & 0o777 == 0o640
    (script,) = tmp_path.glob("src/*/scripts/*")
    assert script.stat().st_mode & 0o777 == 0o750


def test_an_edited_file_is_kept_and_named(tmp_path: Path, shipped: Files) -> None:
    written = write_workspace(tmp_path, shipped)
    (written.source / LAUNCH).write_text(EDIT)
    for newer in (shipped[PurePosixPath(LAUNCH)], b"newer"):
        shipped[PurePosixPath(LAUNCH)] = newer
        again = write_workspace(tmp_path, shipped)
        assert one(again, FileAction.KEEP) == LAUNCH
        assert (written.source / LAUNCH).read_text() == EDIT


def test_force_overwrites_and_keeps_what_it_overwrote(
    tmp_path: Path, shipped: Files
) -> None:
    written = write_workspace(tmp_path, shipped)
    file = written.source / LAUNCH
    for number, aside in enumerate((f"{file}.orig", f"{file}.orig2")):
        file.write_text(EDIT * (number + 1))
        again = write_workspace(tmp_path, shipped, force=True)
        assert again.backups == {file: Path(aside)}
        assert Path(aside).read_text() == EDIT * (number + 1)
        assert file.read_bytes() == shipped[PurePosixPath(LAUNCH)]


def test_a_newer_version_updates_what_nobody_edited(
    tmp_path: Path, shipped: Files
) -> None:
    source = write_workspace(tmp_path, shipped).source
    older = (source / XACRO).read_bytes()
    (source / XACRO).write_text(EDIT)
    shipped[PurePosixPath(LAUNCH)] = b"newer"
    shipped[PurePosixPath(XACRO)] = b"newer"
    again = write_workspace(tmp_path, shipped)
    assert one(again, FileAction.UPDATE) == LAUNCH
    assert one(again, FileAction.KEEP) == XACRO
    assert (source / LAUNCH).read_bytes() == b"newer"
    (source / XACRO).write_bytes(older)  # the edit is taken back
    assert one(write_workspace(tmp_path, shipped), FileAction.UPDATE) == XACRO


def test_what_is_shipped_no_longer_goes_unless_it_was_edited(
    tmp_path: Path, shipped: Files
) -> None:
    source = write_workspace(tmp_path, shipped).source
    (source / XACRO).write_text(EDIT)
    for path in (LAUNCH, XACRO):
        del shipped[PurePosixPath(path)]
    again = write_workspace(tmp_path, shipped, force=True)
    assert one(again, FileAction.REMOVE) == LAUNCH
    assert one(again, FileAction.KEEP) == XACRO
    assert not (source / LAUNCH).exists()
    again = write_workspace(tmp_path, shipped)
    assert source / XACRO not in again.actions  # it is theirs from now on


def test_a_deleted_file_comes_back_and_a_link_stays(
    tmp_path: Path, shipped: Files
) -> None:
    source = write_workspace(tmp_path, shipped).source
    (source / LAUNCH).unlink()
    assert one(write_workspace(tmp_path, shipped), FileAction.ADD) == LAUNCH
    mine = tmp_path / "mine.launch"
    mine.write_text(EDIT)
    (source / LAUNCH).unlink()
    (source / LAUNCH).symlink_to(mine)
    assert one(write_workspace(tmp_path, shipped), FileAction.KEEP) == LAUNCH
    write_workspace(tmp_path, shipped, force=True)
    assert mine.read_text() == EDIT
    assert not (source / LAUNCH).is_symlink()


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"sha256": []}', '{"sha256": {"package.xml": 3}}']
)
def test_without_a_record_what_differs_is_kept(
    tmp_path: Path, shipped: Files, text: str
) -> None:
    source = write_workspace(tmp_path, shipped).source
    (source / "tool0_gazebo" / RECORD_FILE).write_text(text)
    shipped[PurePosixPath(LAUNCH)] = b"newer"
    assert one(write_workspace(tmp_path, shipped), FileAction.KEEP) == LAUNCH


def test_a_run_that_was_cut_short_is_gone_on_with(
    tmp_path: Path, shipped: Files, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = write_workspace(tmp_path, shipped).source
    older = everything(tmp_path)
    replace = Path.replace

    def fails(self: Path, target: Path) -> Path:
        if target.name == Path(LAUNCH).name:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return replace(self, target)

    for path in (LAUNCH, XACRO):
        shipped[PurePosixPath(path)] = b"newer"
    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", fails)
        with pytest.raises(ConfigError) as caught:
            write_workspace(tmp_path, shipped)
    assert "No space left on device" in str(caught.value)
    assert LAUNCH in str(caught.value)
    assert set(everything(tmp_path)) == set(older)  # and nothing half-written beside
    assert (source / LAUNCH).read_bytes() == older[source / LAUNCH]

    shipped[PurePosixPath(XACRO)] = b"newer still"  # as another version would have it
    again = write_workspace(tmp_path, shipped)
    assert set(again.paths(FileAction.UPDATE)) == {source / LAUNCH, source / XACRO}


def test_a_folder_that_is_not_ours_to_write_is_told(
    tmp_path: Path, shipped: Files, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(self: Path, **_: object) -> None:  # root, too, who may write anywhere
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    with monkeypatch.context() as patch:
        patch.setattr(Path, "mkdir", fails)
        with pytest.raises(ConfigError) as error:
            write_workspace(tmp_path, shipped)
    assert os.strerror(errno.EACCES) in str(error.value)


@pytest.mark.parametrize("obstacle", [LAUNCH, "tool0_gazebo"])
def test_what_is_in_the_way_is_named(
    tmp_path: Path, shipped: Files, obstacle: str
) -> None:
    path = tmp_path / "src" / obstacle
    if obstacle == LAUNCH:
        path.mkdir(parents=True)
    else:
        path.parent.mkdir()
        path.touch()
    before = everything(tmp_path)
    with pytest.raises(ConfigError) as error:
        write_workspace(tmp_path, shipped)
    assert str(path) in str(error.value)
    assert everything(tmp_path) == before  # seen before anything was written


# --- the folder ---


def make_package(folder: Path, name: str = "") -> Path:
    folder.mkdir(parents=True)
    text = f"<package><name>{name or folder.name}</name></package>"
    (folder / "package.xml").write_text(text)
    return folder


def test_packages_go_into_src_or_beside_others(tmp_path: Path) -> None:
    assert source_folder(tmp_path / "new") == tmp_path / "new" / "src"
    assert source_folder(tmp_path) == tmp_path / "src"
    assert source_folder(tmp_path / "ws" / "src") == tmp_path / "ws" / "src"
    make_package(tmp_path / "my_robot")
    assert source_folder(tmp_path) == tmp_path
    make_package(tmp_path / "src" / "robotiq" / "robotiq_description")
    assert source_folder(tmp_path) == tmp_path / "src"


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


def test_what_is_no_workspace_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("not a folder")
    (tmp_path / "ws").mkdir()
    (tmp_path / "ws" / "src").write_text("not a folder")
    (tmp_path / "link").symlink_to(tmp_path / "gone")
    package = make_package(tmp_path / "other" / "src" / "my_robot")
    named = (tmp_path / name for name in ("file", "file/deeper", "ws", "link"))
    for folder in (*named, package, package / "src"):
        with pytest.raises(ConfigError):
            source_folder(folder)


def test_a_package_of_the_same_name_elsewhere_is_told(tmp_path: Path) -> None:
    other = make_package(tmp_path / "src" / "copy", "tool0_gazebo")
    with pytest.raises(ConfigError) as error:
        source_folder(tmp_path, PACKAGES)
    assert str(other) in str(error.value)
    assert "tool0_gazebo" in str(error.value)
    (other / "CATKIN_IGNORE").touch()
    assert source_folder(tmp_path, PACKAGES) == tmp_path / "src"
    (tmp_path / "src" / "tool0_gazebo").symlink_to(other)
    with pytest.raises(ConfigError):  # or the linked package would be written to
        source_folder(tmp_path, PACKAGES)
