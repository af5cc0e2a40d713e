"""Whatever is wrong around a command ends it with one line, never with a traceback."""

from __future__ import annotations

import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from served import use_folder

from tool0.cli import FAILED, INTERRUPTED, OK

pytestmark = pytest.mark.slow

BRINGUP = ["bringup", "--headless", "--no-realtime", "--duration", "0.01"]
COMMANDS = {
    "help": ["--help"],
    "help of a command": ["move", "--help"],
    "describe": ["describe", "urdf"],
    "check": ["check", "robot.urdf"],
    "bringup": BRINGUP,
}
URDF = '<robot name="{name}"><link name="base"/></robot>'


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "robot.urdf").write_text(URDF.format(name="fine"), encoding="utf-8")
    return use_folder(monkeypatch, tmp_path)


def run(
    arguments: list[str],
    folder: Path,
    *,
    shell: str = 'exec "$@"',
    python: tuple[str, ...] = ("-m", "tool0"),
    **variables: str,
) -> subprocess.CompletedProcess[str]:
    """Run the command line as ``"$@"`` of a shell."""
    environment = {**os.environ, **variables}
    environment.pop("PYTHONUNBUFFERED", None)  # an output is full when it is flushed
    return subprocess.run(
        ["sh", "-c", shell, "sh", sys.executable, *python, *arguments],
        capture_output=True,
        check=False,
        cwd=folder.parent,
        encoding="utf-8",
        env=environment,
    )


def assert_refused(done: subprocess.CompletedProcess[str], *words: str) -> None:
    assert done.returncode == FAILED, done.stderr
    assert done.stderr.startswith("tool0: error: ")
    assert done.stderr.count("\n") == 1
    for word in words:
        assert word in done.stderr


@pytest.mark.parametrize(
    ("command", "output"),
    [*((name, "/dev/full") for name in COMMANDS), ("help", "&-"), ("bringup", "&-")],
)
def test_an_output_that_cannot_be_written_is_named(
    command: str, output: str, folder: Path
) -> None:
    done = run(COMMANDS[command], folder, shell=f'exec "$@" >{output}')
    assert_refused(done, "cannot write the output")
    assert not list(folder.glob("*"))


def test_with_nowhere_to_write_only_the_status_tells(folder: Path) -> None:
    closed, full = 'exec "$@" <&- >&- 2>&-', 'exec "$@" >/dev/full 2>/dev/full'
    for shell, arguments in (
        (closed, BRINGUP),
        (full, BRINGUP),
        (closed, ["move", "--wrong"]),
        (full, ["state"]),
    ):
        assert run(arguments, folder, shell=shell).returncode == FAILED


def test_a_folder_in_place_of_the_lock_is_named(folder: Path) -> None:
    (folder / "tool0.lock").mkdir(parents=True)
    folder.chmod(0o700)
    assert_refused(run(BRINGUP, folder), "tool0.lock", "directory")


NOBODY = """
import pwd, runpy
def getpwuid(number):
    raise KeyError(number)
pwd.getpwuid = getpwuid
runpy.run_module("tool0", run_name="__main__")
"""


def test_without_a_home_a_variable_is_named(folder: Path) -> None:
    shell = 'unset HOME XDG_DATA_HOME; exec "$@"'
    done = run(BRINGUP, folder, shell=shell, python=("-c", NOBODY))
    assert_refused(done, "HOME")


@pytest.mark.parametrize(
    ("panel", "limit"),
    [
        *(("--no-open", limit) for limit in (6, 8, 10, 12, 14)),
        ("--headless", 5),
        ("--headless", 8),
    ],
)
def test_few_descriptors_are_enough_or_are_named(
    panel: str, limit: int, folder: Path
) -> None:
    arguments = [*BRINGUP, panel]
    done = run(arguments, folder, shell=f'ulimit -n {limit}; exec "$@"')
    if done.returncode != OK:
        assert_refused(done, "open files")
    assert done.stderr.count("\n") <= 1


@pytest.mark.parametrize(
    ("command", "variables"),
    [
        *((name, {"PYTHONIOENCODING": "ascii"}) for name in [*COMMANDS, "tree"]),
        ("tree", {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}),
    ],
)
def test_an_output_in_ascii_is_readable(
    command: str, variables: dict[str, str], folder: Path
) -> None:
    done = run(COMMANDS.get(command, ["describe", "tree"]), folder, **variables)
    assert done.returncode == OK, done.stderr
    assert done.stdout.isascii()
    assert "\\u" not in done.stdout


def test_xml_in_ascii_means_the_same(folder: Path) -> None:
    (folder.parent / "robot.urdf").write_text(URDF.format(name="臂 é"), "utf-8")
    arguments = ["describe", "urdf", "--robot", "robot.urdf"]
    done = run(arguments, folder, PYTHONIOENCODING="ascii")
    assert done.returncode == OK, done.stderr
    assert done.stdout.isascii()
    assert ET.fromstring(done.stdout).get("name") == "臂 é"


CTRL_C = """
import runpy, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)

class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name == MODULE:
            sys.stdout.write("here ")
            sys.stdout.flush()
            signal.raise_signal(signal.SIGINT)

MODULE = sys.argv.pop(1)
sys.meta_path.insert(0, Interrupt())
runpy.run_module("tool0", run_name="__main__")
"""


@pytest.mark.parametrize(
    "module",
    [
        "tool0.cli",
        "tool0.cli.edge",
        "tool0.cli.describe",
        "argparse",
        "tool0.description.robot",
        "xacro",
    ],
)
def test_ctrl_c_during_imports_ends_it_silently(module: str, folder: Path) -> None:
    arguments = [module, "describe", "tree"]
    done = run(arguments, folder, python=("-c", CTRL_C))
    assert done.stdout == "here "
    assert done.stderr == ""
    assert done.returncode in (INTERRUPTED, -2)


AT_EXIT = """
import atexit, runpy, signal
signal.signal(signal.SIGINT, signal.default_int_handler)
atexit.register(signal.raise_signal, signal.SIGINT)
runpy.run_module("tool0", run_name="__main__")
"""


def test_ctrl_c_while_the_interpreter_ends_is_silent(folder: Path) -> None:
    done = run(["--version"], folder, python=("-c", AT_EXIT))
    assert done.stdout.startswith("tool0 ")
    assert done.stderr == ""


MISTAKE = """
import runpy, tool0.cli.sensors
def state():
    return 1 / 0
tool0.cli.sensors.state = state
runpy.run_module("tool0", run_name="__main__")
"""


def test_a_mistake_of_ours_has_a_traceback(folder: Path) -> None:
    done = run(["state"], folder, python=("-c", MISTAKE))
    assert done.returncode == 1
    assert "Traceback" in done.stderr
    assert "ZeroDivisionError" in done.stderr
