"""Installing tool0's own ROS 2, with a Python that only says what it would do."""

import fcntl
import os
import platform
import shutil
import subprocess
import sys
import sysconfig
import time
from pathlib import Path

import pytest
from machine import add_program

from tool0.errors import RosUnavailableError
from tool0.installation.ros2 import generate, install
from tool0.installation.ros2.install import (
    expected_prefix,
    install_ros2,
    uninstall_ros2,
)
from tool0.installation.ros2.installation import current_link, find_own, own_folder

pytestmark = pytest.mark.slow

BASE = """
echo "$@" >> "$LOG"
if [ "$2" = venv ]; then
    mkdir -p "$3/bin"
    printf '#!/bin/sh\\n. "%s"\\n' "$STEPS" > "$3/bin/python"
    chmod +x "$3/bin/python"
fi
"""
STEPS = """
echo "$@" >> "$LOG"
case "$*" in
*"pip install"*) echo Collecting ros-rclpy; eval "$PIP" ;;
*generate.py*) echo control_msgs; eval "$GENERATE" ;;
*) eval "$CHECK" ;;
esac
"""
OFFLINE = """
echo "WARNING: Retrying after connection broken by NewConnectionError"
echo "ERROR: No matching distribution found for ros-rclpy"
exit 1
"""
WITHOUT = 'echo "ERROR: No matching distribution found for ros-rclpy"; exit 1'


class Machine:
    """What the programs do on it, and what they were asked to."""

    def __init__(self, folder: Path, patch: pytest.MonkeyPatch) -> None:
        self._patch, self._log = patch, folder / "log"
        base = add_program(folder / "base-python", BASE)
        (folder / "steps").write_text(STEPS)
        patch.setattr(install, "_base_python", lambda: str(base))
        patch.setenv("LOG", str(self._log))
        patch.setenv("STEPS", str(folder / "steps"))
        for name in ("PIP", "GENERATE", "CHECK", "CC", "CXX"):
            patch.setenv(name, "true")

    def does(self, step: str, script: str) -> None:
        """Let the step run the script."""
        self._patch.setenv(step, script)

    @property
    def log(self) -> list[str]:
        return self._log.read_text().splitlines()


@pytest.fixture(autouse=True)
def machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Machine:
    return Machine(tmp_path, monkeypatch)


def said() -> list[str]:
    activities: list[str] = []
    install_ros2(lambda activity, _: activities.append(activity))
    return list(dict.fromkeys(activities))


def refusal() -> str:
    """Return why it cannot be installed; nothing is left of the attempt."""
    with pytest.raises(RosUnavailableError) as error:
        said()
    if own_folder().is_dir():
        assert {one.name for one in own_folder().iterdir()} <= {"lock"}
    assert find_own() is None
    return str(error.value)


def test_makes_one_selects_it_and_removes_it(machine: Machine) -> None:
    activities = said()
    assert [text.split()[0] for text in activities] == [
        *("making", "installing", "compiling")
    ]
    assert "control_msgs" in activities[-1]
    found = find_own()
    assert found is not None
    assert found.prefix == expected_prefix()
    assert {one.name for one in own_folder().iterdir()} == {
        *("lock", "current", expected_prefix().name)
    }
    assert uninstall_ros2() > 0
    assert not own_folder().exists()
    assert uninstall_ros2() == 0


def test_a_complete_one_is_kept(machine: Machine) -> None:
    said()
    steps = machine.log
    assert said() == []
    assert machine.log == steps


def test_the_one_in_use_outlives_the_next_one_only(
    machine: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    folders = []
    for number in range(3):
        monkeypatch.setattr(install, "WHEELS", (f"ros-rclpy=={number}",))
        said()
        folders.append(expected_prefix())
        assert current_link().resolve() == folders[-1]
        assert [one.is_dir() for one in folders[-2:]] == [True] * min(number + 1, 2)
    assert not folders[0].exists()


def test_a_run_that_was_killed_leaves_nothing_that_counts(
    machine: Machine, tmp_path: Path
) -> None:
    machine.does("GENERATE", f"touch '{tmp_path}/started'; exec sleep 1000")
    program = (
        "from tool0.installation.ros2 import install\n"
        f"install._base_python = lambda: {str(tmp_path / 'base-python')!r}\n"
        "install.install_ros2(lambda activity, fraction: None)\n"
    )
    with subprocess.Popen([sys.executable, "-c", program]) as child:
        deadline = time.monotonic() + 60.0
        while not (tmp_path / "started").exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        child.kill()
    assert expected_prefix().is_dir()
    assert find_own() is None
    machine.does("GENERATE", "true")
    said()
    found = find_own()
    assert found is not None
    assert not (own_folder() / "work").exists()


def test_an_interrupted_run_leaves_nothing(machine: Machine) -> None:
    def interrupt(activity: str, fraction: float) -> None:
        if activity.startswith("compiling"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        install_ros2(interrupt)
    assert {one.name for one in own_folder().iterdir()} == {"lock"}


@pytest.mark.parametrize("step", ["PIP", "GENERATE", "CHECK"])
def test_a_failing_step_is_shown(machine: Machine, step: str) -> None:
    machine.does(step, "echo the reason; exit 3")
    assert "the reason" in refusal()


@pytest.mark.parametrize(
    ("script", "remedy"),
    [
        (OFFLINE, "check the network"),
        (WITHOUT, "PIP_INDEX_URL"),
        ("echo 'OSError: [Errno 28] No space left on device'; exit 2", "disk is full"),
    ],
)
def test_pips_failures_have_remedies(
    machine: Machine, script: str, remedy: str
) -> None:
    machine.does("PIP", script)
    assert remedy in refusal()


def test_what_is_missing_is_named_before_anything_is_downloaded(
    machine: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CXX", "no-such-compiler -O2")
    monkeypatch.setattr(sysconfig, "get_path", lambda name: str(tmp_path))
    add_program(tmp_path / "bin" / "apt-get")
    monkeypatch.setenv("PATH", f"{tmp_path}/bin:{os.environ['PATH']}")
    add_program(tmp_path / "base-python", 'case "$*" in *ensurepip*) exit 1 ;; esac')
    text = refusal()
    for what in ("a C++ compiler", "Python.h", "Python's venv", "apt install g++"):
        assert what in text
    assert not (tmp_path / "log").exists()


def test_a_full_disk_is_noticed_before(
    machine: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    usage = shutil.disk_usage(Path.home())._replace(free=10_000_000)
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: usage)
    assert "0.0 GB free" in refusal()


def test_other_machines_and_pythons_are_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sys, "version_info", (3, 15, 0, "final", 0))
    assert "this is Python 3.15" in refusal()
    monkeypatch.setattr(platform, "machine", lambda: "aarch64")
    assert "aarch64" in refusal()


def test_two_at_once_are_refused(machine: Machine) -> None:
    own_folder().mkdir(parents=True)
    with (own_folder() / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        with pytest.raises(RosUnavailableError, match="another process"):
            said()
        with pytest.raises(RosUnavailableError, match="another process"):
            uninstall_ros2()


def test_it_must_be_possible_to_write_the_folder(tmp_path: Path) -> None:
    own_folder().parent.mkdir(parents=True)
    own_folder().write_text("a file")
    with pytest.raises(RosUnavailableError, match="cannot write"):
        said()


def test_static_names_of_joined_files_do_not_collide(tmp_path: Path) -> None:
    for name in "ab":
        (tmp_path / f"{name}.c").write_text(
            f'static char encoding[] =\n  "{name}";\nstatic const t {name}__H = {{1}};'
            f"\nchar * {name}(void) {{\n  static char local = 1;\n"
            "  return local ? encoding : 0;\n}\n"
        )
    text = generate._joined([tmp_path / "a.c", tmp_path / "b.c"])
    assert "return local ? encoding__0 : 0" in text
    assert "return local ? encoding__1 : 0" in text
    assert "encoding[]" not in text
