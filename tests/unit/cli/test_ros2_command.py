"""``tool0 ros2``: output and exit status, machine by machine."""

import json
import os
import shlex
import subprocess
from pathlib import Path

import pytest
from machine import add_own_ros2, add_program, add_ros2

from tool0.cli import FAILED, OK, main
from tool0.installation.ros2 import install, installation
from tool0.installation.ros2.installation import NODE_FOLDER, own_folder
from tool0.installation.ros2.status import shell_exports

Capture = pytest.CaptureFixture[str]


@pytest.fixture(autouse=True)
def system(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Stand in for /opt/ros; nothing is in it, and nothing is sourced."""
    folder = tmp_path / "opt"
    folder.mkdir()
    monkeypatch.setattr(installation, "SYSTEM_ROOT", folder)
    for name in ("ROS_DISTRO", "ROS_VERSION", "AMENT_PREFIX_PATH", "PYTHONPATH"):
        monkeypatch.delenv(name, raising=False)
    return folder


@pytest.fixture
def own(monkeypatch: pytest.MonkeyPatch) -> Path:
    """Pretend that `tool0 ros2 install` has been run."""
    prefix = add_own_ros2()
    monkeypatch.setattr(
        "tool0.installation.ros2.status.expected_prefix", lambda: prefix
    )
    return prefix


def status(capsys: Capture) -> tuple[int, dict[str, object]]:
    capsys.readouterr()
    code = main(["ros2", "status", "--json"])
    return code, json.loads(capsys.readouterr().out)


def test_status_without_any_fails(capsys: Capture) -> None:
    code, found = status(capsys)
    assert (code, found["can_run"], found["distro"]) == (1, False, None)
    assert found["remedies"] == ["tool0 ros2 install"]
    assert main(["ros2", "status"]) == 1
    assert "tool0 ros2 install" in capsys.readouterr().out


def test_status_of_tool0s_own(capsys: Capture, own: Path) -> None:
    code, found = status(capsys)
    assert (code, found["can_run"], found["kind"]) == (OK, True, "own")
    assert (found["distro"], found["rclpy"]) == ("kilted", "9.1.2")
    assert (found["python_version"], found["rmw"]) == ("3.12.3", "rmw_fastrtps_cpp")
    assert (found["missing"], found["remedies"]) == ({}, [])
    assert main(["ros2", "status"]) == OK
    text = capsys.readouterr().out
    assert f"kilted, tool0's own, 123 MB, {own}" in text
    assert "can start" in text


def test_one_of_an_older_tool0_works_and_can_be_renewed(capsys: Capture) -> None:
    add_own_ros2()
    code, found = status(capsys)
    assert (code, found["remedies"]) == (OK, ["tool0 ros2 install"])


def test_missing_packages_are_named_as_apt_knows_them(
    capsys: Capture, system: Path
) -> None:
    add_ros2(system, "jazzy", lacking=("control_msgs", "ur_msgs"))
    code, found = status(capsys)
    assert (code, found["can_run"]) == (1, False)
    assert found["missing"] == {
        "control_msgs": "no control_msgs",
        "ur_msgs": "no ur_msgs",
    }
    command = "sudo apt install ros-jazzy-control-msgs ros-jazzy-ur-msgs"
    assert found["remedies"] == [command]
    assert main(["ros2", "status"]) == 1
    text = capsys.readouterr().out
    assert "inputs, outputs" in text
    assert "cannot start" in text
    assert main(["ros2", "install"]) == OK
    assert command in capsys.readouterr().out


def test_packages_that_the_node_can_do_without_do_not_stop_it(
    capsys: Capture, system: Path
) -> None:
    add_ros2(system, "humble", python="3.10", lacking=("simulation_interfaces",))
    code, found = status(capsys)
    assert (code, found["can_run"]) == (OK, True)
    command = "sudo apt install ros-humble-simulation-interfaces"
    assert found["remedies"] == [command]


def test_robostack_has_a_command_of_its_own(capsys: Capture, system: Path) -> None:
    prefix = add_ros2(system, "jazzy", lacking=("tf2_msgs",))
    (prefix / "conda-meta").mkdir()
    _, found = status(capsys)
    assert found["remedies"] == [
        "mamba install -c conda-forge -c robostack-jazzy ros-jazzy-tf2-msgs"
    ]


def test_a_python_that_does_not_start_is_reported(
    capsys: Capture, system: Path
) -> None:
    prefix = add_ros2(system, "jazzy")
    add_program(prefix / "bin" / "python3.12", "echo it is broken >&2; exit 1")
    code, found = status(capsys)
    assert (code, found["can_run"], found["python_version"]) == (1, False, None)
    assert "it is broken" in str(found["missing"])
    assert main(["ros2", "status"]) == 1


def test_a_shell_takes_the_variables_and_keeps_tool0(
    capsys: Capture, own: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    venv = tmp_path / "with space"
    monkeypatch.setenv("VIRTUAL_ENV", str(venv))
    monkeypatch.setenv("PATH", f"{venv}/bin:{os.environ['PATH']}")
    monkeypatch.setenv("PYTHONPATH", "/mine")
    monkeypatch.setenv("LD_LIBRARY_PATH", "/other")
    assert main(["ros2", "env"]) == OK
    lines = capsys.readouterr().out
    script = f"{lines}\nenv -0"
    answer = subprocess.run(
        ["sh", "-c", script], capture_output=True, text=True, check=True
    )
    pairs = (entry.partition("=") for entry in answer.stdout.split("\0"))
    after = {name: value for name, _, value in pairs}
    assert after["PATH"].split(":")[0] == str(own / "bin")
    assert f"{venv}/bin" in after["PATH"].split(":")
    assert after["PYTHONPATH"] == f"{NODE_FOLDER}:/mine"
    assert (after["AMENT_PREFIX_PATH"], after["ROS_DISTRO"]) == (str(own), "kilted")
    assert {"VIRTUAL_ENV", "LD_LIBRARY_PATH"}.isdisjoint(after)
    after.pop("_", None)
    assert shell_exports(after) == []  # twice is no more than once


def test_without_ros_2_there_is_nothing_to_export(capsys: Capture) -> None:
    assert main(["ros2", "env"]) == FAILED
    assert "tool0 ros2 install" in capsys.readouterr().err


def test_installing_says_what_is_ready_and_what_comes_first(
    capsys: Capture, own: Path, system: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(install, "expected_prefix", lambda: own)
    assert main(["ros2", "install"]) == OK
    assert capsys.readouterr().out == f"ready: ROS 2 kilted in {own}\n"
    other = add_ros2(system, "jazzy")
    assert main(["ros2", "install"]) == OK
    assert capsys.readouterr().out == f"nothing to do: ROS 2 jazzy is in {other}\n"
    assert main(["ros2", "install", "--own"]) == OK
    text = f"another ROS 2 comes first: jazzy in {other}"
    assert text in capsys.readouterr().out


def test_removing_twice_is_no_error(capsys: Capture, own: Path) -> None:
    assert main(["ros2", "uninstall"]) == OK
    assert not own_folder().exists()
    assert "removed" in capsys.readouterr().out
    assert main(["ros2", "uninstall"]) == OK
    assert capsys.readouterr().out == "nothing to remove\n"


def test_lines_for_the_shell_are_quoted(tmp_path: Path, system: Path) -> None:
    prefix = add_ros2(tmp_path / "a b", "jazzy")
    variables = {"AMENT_PREFIX_PATH": str(prefix), "ROS_DISTRO": "jazzy"}
    for line in shell_exports(variables | {"VIRTUAL_ENV": "/venv"}):
        words = shlex.split(line)
        assert len(words) == 2, line
        assert words[0] in ("export", "unset")
