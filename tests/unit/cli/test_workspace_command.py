"""``tool0 workspace`` says what it did, and what to type next."""

from pathlib import Path

import pytest

from tool0.cli import FAILED, OK, main

pytestmark = pytest.mark.slow

Capture = pytest.CaptureFixture[str]
LAUNCH = "src/tool0_gazebo/launch/bringup.launch"


def test_it_says_what_to_type_next(tmp_path: Path, capsys: Capture) -> None:
    folder = tmp_path / "my ws"
    assert main(["workspace", str(folder)]) == OK
    out = capsys.readouterr().out
    assert f"{folder}/src/tool0_gazebo: files" in out
    assert f"cd '{folder}'\n" in out
    assert "rosdep install --from-paths src --ignore-src --rosdistro noetic -y\n" in out
    assert "catkin_make\n  source devel/setup.bash\n" in out
    for line in out.splitlines():  # what it says to launch is there
        if "roslaunch" in line:
            _, package, file, *_ = line.split()
            assert (folder / "src" / package / "launch" / file).is_file()
    assert "git clone" not in out


def test_upstream_meshes_need_a_clone(tmp_path: Path, capsys: Capture) -> None:
    assert main(["workspace", str(tmp_path), "--upstream-meshes"]) == OK
    assert "robotiq.git src/robotiq\n" in capsys.readouterr().out
    assert 'default="upstream"' in (tmp_path / LAUNCH).read_text()


def test_edited_files_are_named_and_what_to_do(tmp_path: Path, capsys: Capture) -> None:
    main(["workspace", str(tmp_path)])
    (tmp_path / LAUNCH).write_text("<launch/>")
    capsys.readouterr()
    assert main(["workspace", str(tmp_path)]) == OK
    out = capsys.readouterr().out
    assert f"kept: {tmp_path / LAUNCH}; you have edited it" in out
    assert "--force overwrites them" in out
    assert main(["workspace", str(tmp_path), "--force"]) == OK
    out = capsys.readouterr().out
    assert f"your version: {tmp_path / LAUNCH}.orig" in out
    assert "kept" not in out


@pytest.mark.parametrize(
    ("folder", "command"),
    [
        ("src/group", "catkin_make\n"),
        ("packages", "catkin_make --source packages\n"),
    ],
)
def test_the_commands_are_for_the_workspace_above_the_packages(
    tmp_path: Path, capsys: Capture, folder: str, command: str
) -> None:
    (tmp_path / folder / "mine").mkdir(parents=True)
    (tmp_path / folder / "mine" / "package.xml").write_text("<package/>")
    assert main(["workspace", str(tmp_path / folder)]) == OK
    out = capsys.readouterr().out
    assert f"  cd {tmp_path}\n" in out
    assert command in out
    assert (tmp_path / folder / "tool0_gazebo" / "package.xml").is_file()


def test_what_cannot_be_is_an_error(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "file").touch()
    assert main(["workspace", str(tmp_path / "file")]) == FAILED
    assert "is not a folder" in capsys.readouterr().err
