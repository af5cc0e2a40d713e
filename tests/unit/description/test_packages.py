import os
from pathlib import Path

import pytest

from tool0.control.config import ControllerConfig
from tool0.description.loading import load_robot
from tool0.description.packages import find_package, resolve_uri
from tool0.errors import DescriptionError, SourceLocation


def make_package(folder: Path, name: str) -> Path:
    folder.mkdir(parents=True)
    text = f"<package format='3'>\n  <name> {name} </name>\n</package>"
    (folder / "package.xml").write_text(text)
    return folder


def test_finds_packages_at_and_below_each_entry_by_their_name_not_their_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    itself = make_package(tmp_path / "a", "alone")
    deep = make_package(tmp_path / "src" / "group" / "folder", "deep_one")
    entries = (tmp_path / "missing", itself, tmp_path / "src")
    monkeypatch.setenv("ROS_PACKAGE_PATH", os.pathsep.join(map(str, entries)))
    assert find_package("alone") == itself
    assert find_package("deep_one") == deep
    make_package(tmp_path / "src" / "old" / "p", "shadow")
    (tmp_path / "src" / "old" / "CATKIN_IGNORE").touch()
    for name in ("folder", "shadow"):
        with pytest.raises(DescriptionError):
            find_package(name)


def test_finds_packages_that_ros2_has_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    prefixes = (tmp_path / "missing", tmp_path / "overlay", tmp_path / "underlay")
    monkeypatch.setenv("AMENT_PREFIX_PATH", os.pathsep.join(map(str, prefixes)))
    make_package(tmp_path / "underlay" / "share" / "arm_description", "arm_description")
    first = make_package(
        tmp_path / "overlay" / "share" / "arm_description", "arm_description"
    )
    assert find_package("arm_description") == first
    with pytest.raises(DescriptionError, match=r"overlay/share.*'arm_description'"):
        find_package("arm_descripton")
    sources = make_package(tmp_path / "src" / "arm_description", "arm_description")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "src"))
    assert find_package("arm_description") == sources


def test_bundled_packages_come_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    assert (find_package("tool0_description") / "package.xml").is_file()
    make_package(tmp_path / "x", "tool0_description")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    assert tmp_path not in find_package("tool0_description").parents


def test_a_missing_package_says_where_it_was_sought_and_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make_package(tmp_path / "p", "ur_description")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    with pytest.raises(DescriptionError) as caught:
        find_package("ur_descripton", SourceLocation(Path("cell.xacro"), 7))
    assert str(caught.value.location) == "cell.xacro:7"
    for named in (str(tmp_path), "'ur_description'", "ROS_PACKAGE_PATH"):
        assert named in str(caught.value)


def test_uris_resolve_to_paths(tmp_path: Path) -> None:
    here = SourceLocation(tmp_path / "cell.urdf", 3)
    assert resolve_uri("meshes/a.stl", here) == tmp_path / "meshes" / "a.stl"
    assert resolve_uri("/a/b.stl", here) == Path("/a/b.stl")
    assert resolve_uri("file:///a/b.stl", here) == Path("/a/b.stl")
    package = find_package("tool0_description")
    assert resolve_uri("package://tool0_description/m/a.stl") == package / "m" / "a.stl"
    with pytest.raises(DescriptionError) as caught:
        resolve_uri("http://example.org/a.stl")
    assert "'http://'" in str(caught.value)


def test_a_robot_file_finds_the_packages_of_its_own_workspace(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    source = tmp_path / "catkin_ws" / "src"
    arm = make_package(source / "vendor" / "my_arm", "my_arm")
    cell = make_package(source / "my_cell", "my_cell")
    (arm / "links.xacro").write_text('<robot><link name="base_link"/></robot>')
    file = cell / "cell.urdf.xacro"
    include = '<xacro:include filename="$(find my_arm)/links.xacro"/>'
    xmlns = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
    file.write_text(f'<robot name="cell" {xmlns}>{include}</robot>')
    assert load_robot(file).model.root == "base_link"

    file.write_text(file.read_text().replace("my_arm", "my_arn"))
    with pytest.raises(DescriptionError) as raised:
        load_robot(file)
    text = str(raised.value)
    assert (
        "there is no ROS package 'my_arn' in the workspace ('my_arm', 'my_cell')"
        in text
    )
    assert "did you mean 'my_arm'?" in text


def test_a_yaml_for_ros_2_finds_the_packages_of_its_own_workspace(
    tmp_path: Path,
) -> None:
    package = make_package(tmp_path / "src" / "my_cell", "my_cell")
    file = package / "controllers.yaml"
    file.write_text(
        "arm_controller:\n  ros__parameters:\n"
        "    file: $(find-pkg-share my_cell)/gains.yaml\n"
    )
    tree = ControllerConfig.from_files(file).tree.root
    value = tree.find("arm_controller/ros__parameters/file")
    assert value is not None
    assert value.scalar == f"{package}/gains.yaml"
