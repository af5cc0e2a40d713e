from pathlib import Path

import pytest

from tool0.installation.doctor.line import Line
from tool0.installation.doctor.machine import Machine
from tool0.installation.doctor.workspace import _NATIVE, workspace

BOOKWORM = "PRETTY_NAME='Debian 12'\nVERSION_CODENAME=bookworm\n"
FOCAL = "PRETTY_NAME='Ubuntu 20.04'\nVERSION_CODENAME=focal\n"
NOBLE = "PRETTY_NAME='Ubuntu 24.04'\nVERSION_CODENAME=noble\n"


def look(root: Path, release: str, *programs: str) -> tuple[Line, Line]:
    for name in ("apt-get", *programs):
        file = root / "bin" / name
        file.parent.mkdir(exist_ok=True)
        file.write_text("#!/bin/sh\n")
        file.chmod(0o755)
    (root / "etc").mkdir(exist_ok=True)
    (root / "etc/os-release").write_text(release)
    environ = {"PATH": str(root / "bin")}
    build, native = workspace(Machine(root=root, environ=environ, system="linux"))
    return build, native


def add_packages(prefix: Path, *names: str) -> None:
    for name in names:
        manifest = prefix / "share" / name / "package.xml"
        manifest.parent.mkdir(parents=True)
        manifest.touch()


def test_what_builds_is_told(tmp_path: Path) -> None:
    build, _ = look(tmp_path, NOBLE, "catkin_make", "cmake", "make")
    assert (build.what, build.state) == ("catkin", "ready")
    assert str(tmp_path / "bin/catkin_make") in build.found


@pytest.mark.parametrize(
    ("release", "programs", "state", "remedy"),
    [
        (BOOKWORM, (), "missing", "sudo apt install catkin cmake make"),
        (BOOKWORM, ("make",), "missing", "sudo apt install catkin cmake"),
        (NOBLE, ("catkin_make", "make"), "missing", "sudo apt install cmake"),
        (NOBLE, ("cmake", "make"), "not supported", ""),
    ],
)
def test_what_builds_is_installed_where_it_is_packaged(
    tmp_path: Path, release: str, programs: tuple[str, ...], state: str, remedy: str
) -> None:
    build, _ = look(tmp_path, release, *programs)
    assert (build.state, build.remedy) == (state, remedy)


def test_a_noetic_that_is_not_sourced_is_to_be(tmp_path: Path) -> None:
    setup = tmp_path / "opt/ros/noetic/setup.bash"
    setup.parent.mkdir(parents=True)
    setup.touch()
    build, _ = look(tmp_path, FOCAL, "cmake", "make")
    assert build.remedy == f"source {setup}"


def test_a_whole_noetic_runs_natively(tmp_path: Path) -> None:
    add_packages(tmp_path / "opt/ros/noetic", *_NATIVE)
    _, native = look(tmp_path, FOCAL)
    assert native.state == "ready"
    assert native.found.startswith(str(tmp_path / "opt/ros/noetic"))


def test_what_a_noetic_lacks_is_installed_by_its_names(tmp_path: Path) -> None:
    lacking = {"gazebo_ros_control", "rqt_joint_trajectory_controller"}
    add_packages(tmp_path / "opt/ros/noetic", *(set(_NATIVE) - lacking))
    _, native = look(tmp_path, FOCAL)
    assert native.state == "missing"
    assert native.remedy == (
        "sudo apt install ros-noetic-gazebo-ros-control "
        "ros-noetic-rqt-joint-trajectory-controller"
    )


def test_an_ubuntu_20_04_without_noetic_can_have_it(tmp_path: Path) -> None:
    _, native = look(tmp_path, FOCAL)
    assert native.state == "missing"
    assert native.remedy == "sudo apt install ros-noetic-desktop-full"
    assert "wiki.ros.org/noetic/Installation/Ubuntu" in native.found


def test_elsewhere_tool0_presents_the_same(tmp_path: Path) -> None:
    _, native = look(tmp_path, BOOKWORM)
    assert (native.state, native.remedy) == ("not supported", "")
    assert "tool0 bringup --engine gazebo --ros1" in native.found
