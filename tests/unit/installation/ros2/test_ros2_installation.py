"""Which ROS 2 is found, and the variables of a process that uses it."""

from pathlib import Path

import pytest
from machine import add_own_ros2, add_program, add_ros2

from tool0.installation.ros2 import installation
from tool0.installation.ros2.installation import MARKER, current_link, find_ros2

PLAIN = {"PATH": "/usr/bin:/bin", "HOME": "/home/me"}


@pytest.fixture(autouse=True)
def system(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Stand in for /opt/ros; nothing is in it."""
    folder = tmp_path / "opt"
    folder.mkdir()
    monkeypatch.setattr(installation, "SYSTEM_ROOT", folder)
    return folder


def sourced(prefix: Path, distro: str) -> dict[str, str]:
    return {**PLAIN, "AMENT_PREFIX_PATH": str(prefix), "ROS_DISTRO": distro}


def test_a_machine_may_have_none() -> None:
    assert find_ros2(PLAIN) is None


def test_the_newest_of_the_system_is_used_with_its_setup_file(system: Path) -> None:
    for distro in ("humble", "jazzy", "foxy"):
        add_ros2(system, distro)
    found = find_ros2(PLAIN)
    assert found is not None
    assert (found.kind, found.distro) == ("system", "jazzy")
    assert found.python == system / "jazzy" / "bin" / "python3.12"
    assert found.environment["SOURCED"] == "jazzy"
    assert found.environment["HOME"] == "/home/me"
    assert found.version("rclpy") == "9.1.2"
    assert found.version("control_msgs") is None


def test_a_sourced_one_comes_first(system: Path, tmp_path: Path) -> None:
    add_ros2(system, "kilted")
    prefix = add_ros2(tmp_path, "humble", python="3.10")
    found = find_ros2(sourced(prefix, "humble") | {"LD_LIBRARY_PATH": "/lib/ros"})
    assert found is not None
    assert (found.kind, found.distro, found.prefix) == ("sourced", "humble", prefix)
    assert found.environment["LD_LIBRARY_PATH"] == "/lib/ros"
    assert "SOURCED" not in found.environment  # nothing is sourced again


def test_a_workspace_over_it_is_no_obstacle(tmp_path: Path) -> None:
    prefix, workspace = add_ros2(tmp_path, "jazzy"), tmp_path / "ws"
    variables = sourced(prefix, "jazzy")
    variables["AMENT_PREFIX_PATH"] = f"{workspace}:{prefix}"
    found = find_ros2(variables)
    assert found is not None
    assert found.prefix == prefix
    assert found.prefixes == [workspace, prefix]


def test_a_sourced_ros_1_is_not_one(tmp_path: Path) -> None:
    variables = sourced(add_ros2(tmp_path, "noetic"), "noetic")
    assert find_ros2(variables | {"ROS_VERSION": "1"}) is None


def test_one_for_a_python_that_is_too_old_is_not_used(system: Path) -> None:
    add_ros2(system, "humble", python="3.8")
    assert find_ros2(PLAIN) is None


def test_one_without_its_python_is_not_used(
    system: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    prefix = add_ros2(system, "humble", python="3.99")
    prefix.joinpath("bin", "python3.99").unlink()
    assert find_ros2(PLAIN) is None
    elsewhere = add_program(system.parent / "bin" / "python3.99")
    monkeypatch.setenv("PATH", str(elsewhere.parent))
    found = find_ros2(PLAIN)
    assert found is not None
    assert found.python == elsewhere


def test_the_systems_comes_before_tool0s_own(system: Path) -> None:
    add_own_ros2()
    found = find_ros2(PLAIN)
    assert found is not None
    assert found.kind == "own"
    add_ros2(system, "humble")
    found = find_ros2(PLAIN)
    assert found is not None
    assert found.kind == "system"


def test_an_unfinished_one_is_not_used() -> None:
    prefix = add_own_ros2()
    for text in ("", "[]", '{"format": 99, "distro": "kilted"}', '{"format": 1}'):
        (prefix / MARKER).write_text(text)
        assert find_ros2(PLAIN) is None
    (prefix / MARKER).unlink()
    assert find_ros2(PLAIN) is None


def test_one_whose_python_was_removed_is_not_used(tmp_path: Path) -> None:
    python = add_own_ros2() / "bin" / "python"
    base = python.rename(tmp_path / "python")
    python.symlink_to(base)
    assert find_ros2(PLAIN) is not None
    base.unlink()
    assert find_ros2(PLAIN) is None


def test_tool0s_own_python_does_not_leak_into_it(tmp_path: Path) -> None:
    prefix, venv = add_own_ros2(), tmp_path / "venv"
    found = find_ros2(
        {
            "PATH": f"{venv}/bin:/usr/bin",
            "VIRTUAL_ENV": str(venv),
            "PYTHONHOME": "/somewhere",
            "PYTHONPATH": "/modules",
            "LD_LIBRARY_PATH": "/other/wheels",
            "_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1",
            "RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp",
            "ROS_DOMAIN_ID": "7",
        }
    )
    assert found is not None
    assert found.python == prefix / "bin" / "python"
    assert found.environment == {
        "PATH": f"{prefix}/bin:/usr/bin",
        "AMENT_PREFIX_PATH": str(prefix),
        "ROS_DISTRO": "kilted",
        "ROS_VERSION": "2",
        "ROS_PYTHON_VERSION": "3",
        "ROS_DOMAIN_ID": "7",
    }


def test_its_only_middleware_can_be_named() -> None:
    add_own_ros2()
    found = find_ros2(PLAIN | {"RMW_IMPLEMENTATION": "rmw_fastrtps_cpp"})
    assert found is not None
    assert found.environment["RMW_IMPLEMENTATION"] == "rmw_fastrtps_cpp"


def test_tool0s_own_can_be_sourced_too(system: Path) -> None:
    prefix = add_own_ros2()
    first = find_ros2(PLAIN)
    add_ros2(system, "jazzy")
    current_link().unlink()
    assert first is not None
    again = find_ros2(first.environment)
    assert again == first
    assert again.prefix == prefix
