"""``tool0 ros1 install`` and ``status``: output and commands, machine by machine."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from machine import add_program
from promised import require_ros

from tool0.cli import FAILED, OK, main
from tool0.installation.machine import Machine
from tool0.installation.ros1 import packages
from tool0.installation.ros1.install import PYTHON_OF_RELEASE, not_installed
from tool0.installation.ros1.library import is_of_distribution
from tool0.installation.ros1.packages import (
    COMPONENTS,
    RosComponent,
    required_components,
)

Capture = pytest.CaptureFixture[str]

OURS = f"{sys.version_info.major}.{sys.version_info.minor}"
RELEASES = {
    "bookworm": {"PRETTY_NAME": "Debian 12", "VERSION_CODENAME": "bookworm"},
    "mint": {
        "PRETTY_NAME": "Linux Mint 21",
        "VERSION_CODENAME": "vanessa",
        "UBUNTU_CODENAME": "jammy",
    },
    "noble": {"PRETTY_NAME": "Ubuntu 24.04", "VERSION_CODENAME": "noble"},
    "focal": {"PRETTY_NAME": "Ubuntu 20.04", "VERSION_CODENAME": "focal"},
    "arch": {"PRETTY_NAME": "Arch Linux"},
}
NOTHING_INSTALLED = "exit 1"
APT = """
echo "$@" >> "$(dirname "$0")/log"
case "$*" in *install*)
    echo "dlstatus:1:50.0:Retrieving"
    echo "pmstatus:python3-rospy:80.0:Unpacking"
esac
"""


class Host:
    """A machine whose distribution and programs are what a test says."""

    def __init__(self, folder: Path, patch: pytest.MonkeyPatch) -> None:
        self._programs, self._patch = folder / "bin", patch
        self._programs.mkdir()
        patch.setenv("PATH", f"{self._programs}:/bin")
        for name in ("ROS_DISTRO", "ROS_VERSION"):
            patch.delenv(name, raising=False)
        self.runs("bookworm")
        patch.setitem(PYTHON_OF_RELEASE, "bookworm", OURS)
        self.has("dpkg-query", NOTHING_INSTALLED)
        self.has("apt-get", APT)
        self.has("sudo", "exit 1")
        self.is_root(True)

    def runs(self, release: str) -> None:
        self._patch.setattr(Machine, "release", lambda _: RELEASES[release])

    def has(self, program: str, script: str) -> None:
        add_program(self._programs / program, script)

    def is_root(self, it_is: bool) -> None:
        self._patch.setattr(os, "geteuid", lambda: 0 if it_is else 1000)

    @property
    def asked(self) -> list[str]:
        """What apt-get was called with."""
        return (self._programs / "log").read_text().splitlines()


@pytest.fixture
def host(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Host:
    return Host(tmp_path, monkeypatch)


def refusal(capsys: Capture, *arguments: str) -> str:
    assert main(["ros1", "install", *arguments]) == FAILED
    return capsys.readouterr().err


def test_a_dry_run_prints_the_command(host: Host, capsys: Capture) -> None:
    assert main(["ros1", "install", "--dry-run"]) == OK
    command = capsys.readouterr().out
    assert command.startswith("apt-get update && apt-get install --yes")
    assert "--no-install-recommends -o DPkg::Lock::Timeout=300" in command
    for name in ("python3-rospy", "python3-roslaunch", "ros-robot-state-publisher"):
        assert name in command.split()
    assert "rviz" not in command
    host.is_root(False)
    assert main(["ros1", "install", "--dry-run", "--rviz"]) == OK
    command = capsys.readouterr().out
    assert "&& sudo apt-get install" in command
    assert command.split()[-1] == "rviz"


def test_only_what_is_missing_is_installed(host: Host, capsys: Capture) -> None:
    names = [name for part in required_components(rviz=False) for name in part.debian]
    rows = "".join(f"echo {name} installed\n" for name in names[1:])
    host.has("dpkg-query", f"echo {names[0]} config-files\n{rows}exit 0")
    assert main(["ros1", "install", "--dry-run"]) == OK
    assert capsys.readouterr().out.endswith(f"Timeout=300 {names[0]}\n")
    host.has("dpkg-query", f"echo {names[0]} installed\n{rows}exit 0")
    assert main(["ros1", "install"]) == OK
    assert "nothing to do: Debian 12" in capsys.readouterr().out


def test_it_installs_and_prints_its_progress(host: Host, capsys: Capture) -> None:
    assert main(["ros1", "install"]) == OK
    output = capsys.readouterr()
    assert output.out.startswith(
        "installing ROS 1 by apt, from Debian 12: python3-rospy"
    )
    assert output.out.splitlines()[-1].startswith("ready: tool0 bringup --ros1")
    assert output.err.splitlines()[-2:] == ["downloading", "installing"]
    update, install = host.asked
    assert update.endswith("update")
    assert "--no-install-recommends" in install
    assert "DPkg::Lock::Timeout=300" in install


def test_without_root_it_uses_sudo_or_prints_the_command(
    host: Host, capsys: Capture
) -> None:
    host.is_root(False)
    output = refusal(capsys)
    assert "sudo apt-get install --yes --no-install-recommends" in output
    assert "python3-rospy" in output
    host.has("sudo", 'shift; exec "$@"')
    assert main(["ros1", "install"]) == OK
    assert "python3-rospy" in host.asked[-1]


@pytest.mark.parametrize(
    ("script", "cause"),
    [
        ("echo 'Err:1 x: Temporary failure resolving h'; exit 100", "http_proxy"),
        ("echo 'E: Unable to locate package rviz'; exit 100", "`universe`"),
        ("echo 'E: You do not have enough free space'; exit 100", "1 GB"),
        ("echo 'E: Could not get lock /x/lock'; exit 100", "another program"),
        ("echo 'E: whatever'; exit 77", "status 77"),
        (
            "case $* in *update) echo 'W: Failed to fetch x  Could not resolve h';; "
            "*) echo 'E: Unable to locate package rviz'; exit 100;; esac",
            "http_proxy",
        ),
    ],
)
def test_failures_of_apt_are_explained(
    script: str, cause: str, host: Host, capsys: Capture
) -> None:
    host.has("apt-get", script)
    output = refusal(capsys)
    assert cause in output
    assert script.split("'")[1] in output
    assert "apt-get install --yes" in output


@pytest.mark.parametrize(
    ("release", "remedy"),
    [("noble", "RoboStack"), ("arch", "RoboStack"), ("focal", "setup.bash")],
)
def test_a_distribution_without_ros_1_has_alternatives(
    release: str, remedy: str, host: Host, capsys: Capture
) -> None:
    host.runs(release)
    output = refusal(capsys)
    assert RELEASES[release]["PRETTY_NAME"] in output
    assert remedy in output


def test_a_derivative_is_what_it_is_built_on(
    host: Host, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    host.runs("mint")
    monkeypatch.setitem(PYTHON_OF_RELEASE, "jammy", OURS)
    assert main(["ros1", "install", "--dry-run"]) == OK
    monkeypatch.setitem(PYTHON_OF_RELEASE, "jammy", "3.1")
    output = refusal(capsys)
    assert f"Linux Mint 21 are for Python 3.1, and this is Python {OURS}" in output
    assert "PYTHON=/usr/bin/python3" in output


def test_without_apt_it_names_the_packages(host: Host, capsys: Capture) -> None:
    host.has("dpkg-query", "")
    os.environ["PATH"] = os.environ["PATH"].split(":")[0]
    Path(os.environ["PATH"], "apt-get").unlink()
    assert "no apt-get; install the equivalent of: python3-rospy" in refusal(capsys)


# --- beside a ROS of another origin ---


MODULE = "def get_master_uri(): return 'http://127.0.0.1:1'\n"
"""Enough of rosgraph to find that there is no master."""


def sourced(prefix: Path, parts: tuple[RosComponent, ...]) -> dict[str, str]:
    """Return the environment of a Noetic with these parts, made in a folder."""
    modules = prefix / "lib" / "python3" / "dist-packages"
    for part in parts:
        for name in part.modules:
            (modules / name).mkdir(parents=True)
            (modules / name / "__init__.py").write_text(MODULE)
        for name in (*part.nodes, *(f"../bin/{name}" for name in part.programs)):
            file = prefix / "lib" / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.touch(mode=0o755)
        for name in part.definitions:
            (prefix / "share" / name / "msg").mkdir(parents=True)
    manifest = prefix / "share" / "rospy" / "package.xml"
    manifest.parent.mkdir(parents=True)
    manifest.write_text("<package><version>1.17.4</version></package>")
    return {
        **os.environ,
        "PATH": f"{prefix}/bin:/bin",
        "PYTHONPATH": str(modules),
        "ROS_DISTRO": "noetic",
        "ROS_VERSION": "1",
    }


def tool0(
    environment: dict[str, str], *arguments: str
) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, "-m", "tool0", "ros1", *arguments],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


def test_beside_a_sourced_ros_there_is_nothing_to_do(tmp_path: Path) -> None:
    environment = sourced(tmp_path, COMPONENTS)
    answer = tool0(environment, "install", "--rviz")
    assert answer.returncode == OK, answer.stderr
    assert answer.stdout.startswith("nothing to do: ROS noetic")
    answer = tool0(environment, "status", "--json")
    assert answer.returncode == OK, answer.stderr
    found = json.loads(answer.stdout)
    assert (found["version"], found["source"]) == ("1.17.4", "ROS noetic")
    assert all(found["parts"].values())


def test_what_a_sourced_ros_lacks_is_named(tmp_path: Path) -> None:
    environment = sourced(
        tmp_path,
        tuple(part for part in COMPONENTS if part.name != "robot_state_publisher"),
    )
    answer = tool0(environment, "install")
    assert answer.returncode == FAILED
    assert "without: robot_state_publisher" in answer.stderr
    assert "ros-noetic-robot-state-publisher" in answer.stderr
    answer = tool0(environment, "status")
    assert answer.returncode == OK  # tool0 publishes /tf itself then
    assert "ros-noetic-robot-state-publisher" in answer.stdout


def test_each_kind_of_ros_has_its_own_installer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (rviz,) = (part for part in COMPONENTS if part.name == "rviz")
    monkeypatch.setenv("ROS_DISTRO", "noetic")
    for kind, prefix, command in (
        ("ROS noetic", Path("/opt/ros/noetic"), "sudo apt-get install ros-noetic-rviz"),
        (
            "RoboStack",
            Path("/home/x/env"),
            "mamba install -c conda-forge -c robostack-noetic ros-noetic-rviz",
        ),
    ):
        monkeypatch.setattr(packages, "ros_origin", lambda kind=kind: kind)
        monkeypatch.setattr(
            packages, "package_prefix", lambda name, prefix=prefix: prefix
        )
        assert packages.other_install_command([rviz]) == command


def test_a_ros_that_is_named_but_not_found_is_reported(
    host: Host, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_DISTRO", "noetic")
    monkeypatch.setattr("tool0.installation.ros1.library.DEBIAN", Path("/nowhere"))
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert "source /opt/ros/noetic/setup.bash" in refusal(capsys)
    monkeypatch.setenv("ROS_VERSION", "2")
    assert main(["ros1", "install", "--dry-run"]) == OK


# --- the real ones ---


def test_with_everything_installed_the_status_is_good(
    capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    require_ros(rviz=True)
    assert main(["ros1", "status"]) == OK
    assert "to do" not in capsys.readouterr().out
    if is_of_distribution():
        assert not_installed(n for part in COMPONENTS for n in part.debian) == ()


def test_without_rospy_the_status_says_what_to_do(
    capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tool0.installation.ros1.library.DEBIAN", Path("/nowhere"))
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert main(["ros1", "status", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["can_run"] is False
    assert "tool0 ros1 install" in found["remedies"][0]
    assert packages.ros1_status().why_not(["rospy"]) is not None
