"""Installs ROS 2 from PyPI wheels into the user's data folder, or removes it.

The wheels do not include control_msgs and other packages.  The missing packages are
generated from tool0's definitions and compiled.  An installation is a virtual
environment in a folder whose name is derived from the folder's contents.  A link
selects the current installation.  Programs that run from the previous installation
continue to run, because it is deleted only by the next installation.
"""

from __future__ import annotations

import hashlib
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Final

from tool0.errors import RosUnavailableError
from tool0.installation.apt import ProgressCallback
from tool0.installation.child_process import ChildProcess, last_lines
from tool0.installation.machine import Machine
from tool0.installation.own_folder import exclusive, removed, size_on_disk
from tool0.installation.ros2 import generate
from tool0.installation.ros2.installation import (
    Ros2,
    current_link,
    find_own,
    mark_complete,
    own_folder,
    own_python,
    plain_environment,
    read_marker,
)

DISTRO: Final = "kilted"
WHEELS: Final = ("ros-rclpy[fastrtps]==9.1.2", "ros-common-interfaces==5.5.1")
"""PyPI packages of this distribution, for Python 3.10 to 3.14 on x86-64 Linux."""
PYTHONS: Final = ((3, 10), (3, 14))
_N_WHEELS: Final = 85
"""Approximate number of lines about collected packages in pip's output."""
DEFINITIONS: Final = Path(__file__).parent / "definitions"
"""Folder of the definitions.  The folder contains one folder per package of Kilted,
with msg/, srv/ and action/."""
_NEEDED: Final = 700_000_000
"""Disk space that the installation needs [bytes].  Of this space, 300 MB remain in
use."""
_COMPILERS: Final = {
    "CC": ("gcc", "cc", "clang"),
    "CXX": ("g++", "c++", "clang++"),
}
"""Compilers that are tried if the variable is not set, by environment variable."""
_POLL_PERIOD: Final = 0.2
"""Interval at which a program's output is polled [wall s]."""
_FAILURES: Final = {
    "no space left": "the disk is full",
    "retrying|connection|resolve|timed out|ssl": (
        "the package index cannot be reached: check the network, or set the proxy in "
        "https_proxy"
    ),
    "no matching distribution|no such": (
        "the package index lacks ROS 2's wheels; name one that has them in "
        "PIP_INDEX_URL, such as https://pypi.org/simple"
    ),
}
"""Explanations of failures, by pattern of pip's output.  The first pattern that matches
applies."""
_CHECK: Final = """\
import importlib, pathlib, sys
import rclpy
from rosidl_generator_py import import_type_support
for folder in pathlib.Path(sys.argv[1]).iterdir():
    import_type_support(folder.name)
    for kind in folder.iterdir():
        module = importlib.import_module(f"{folder.name}.{kind.name}")
        for file in kind.iterdir():
            getattr(module, file.stem).__import_type_support__()
"""


def install_ros2(progress: ProgressCallback) -> Ros2:
    """Return tool0's own ROS 2.  Install ROS 2 if it is missing or out of date.

    Raises:
        RosUnavailableError: If ROS 2 cannot be installed.  The message contains the
            reason and the remedy.
    """
    reason = why_not_installable()
    if reason is not None:
        raise RosUnavailableError(reason)
    prefix = expected_prefix()
    with exclusive(own_folder(), "ROS 2", RosUnavailableError):
        if read_marker(prefix) is None:
            _require_tools()
            _require_space()
            previous = current_link().resolve()
            for folder in _leftovers(keep=(prefix, previous)):
                shutil.rmtree(folder)
            try:
                _make(prefix, progress)
            except BaseException:
                shutil.rmtree(prefix, ignore_errors=True)
                raise
        _select(prefix)
    made = find_own()
    assert made is not None  # the installation has just been selected
    return made


def uninstall_ros2() -> int:
    """Remove all installations of tool0's own ROS 2.

    Returns:
        The freed disk space [bytes].
    """
    return removed(own_folder(), "ROS 2", RosUnavailableError)


def expected_prefix() -> Path:
    """Return the installation folder for this version of tool0 and its Python."""
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    digest = hashlib.sha256(f"{WHEELS} {version}".encode())
    for file in (Path(generate.__file__), *sorted(DEFINITIONS.glob("*/*/*"))):
        digest.update(f"\0{file.parent.name}/{file.name}\0".encode())
        digest.update(file.read_bytes())
    return own_folder() / f"{DISTRO}-py{version}-{digest.hexdigest()[:12]}"


def _leftovers(keep: Sequence[Path]) -> list[Path]:
    folders = [one for one in own_folder().iterdir() if one.is_dir()]
    return [one for one in folders if not one.is_symlink() and one not in keep]


def _select(prefix: Path) -> None:
    """Make the link refer to this installation.  The change is atomic."""
    new = current_link().with_name("next")
    new.unlink(missing_ok=True)
    new.symlink_to(prefix.name)
    new.replace(current_link())


# --- what it needs ---


def why_not_installable() -> str | None:
    """Return why no wheels fit this machine, or None if there are suitable wheels."""
    version = sys.version_info[:2]
    advice = (
        "install ROS 2 another way, and source its setup file (docs/how-to/ros2.md)"
    )
    if (sys.platform, platform.machine()) != ("linux", "x86_64"):
        return (
            "PyPI has wheels of ROS 2 for Linux on x86-64, not for "
            f"{platform.system()} on {platform.machine()}; {advice}"
        )
    if not PYTHONS[0] <= version <= PYTHONS[1]:
        return (
            "PyPI has wheels of ROS 2 for Python 3.10 to 3.14, and this is Python "
            f"{version[0]}.{version[1]}; {advice}"
        )
    return None


def _require_tools() -> None:
    """Raise RosUnavailableError if a compiler or a part of Python is missing."""
    missing = []
    for command in _compilers().values():
        if shutil.which(shlex.split(command)[0]) is None:
            missing.append(("a C++ compiler", "g++"))
    is_distributions = Path(_base_python()).resolve().is_relative_to("/usr/bin")
    name = "python3" if is_distributions else "python"
    if not Path(sysconfig.get_path("include"), "Python.h").is_file():
        missing.append(("Python.h", f"{name}-dev"))
    done = ChildProcess([_base_python(), "-c", "import ensurepip, venv"])
    with done:
        if done.wait() != 0:
            missing.append(("Python's venv", f"{name}-venv"))
    if missing:
        missing = list(dict.fromkeys(missing))
        what = " and ".join(name for name, _ in missing)
        remedy = Machine().install_command(" ".join(name for _, name in missing))
        raise RosUnavailableError(
            f"making ROS 2's message packages needs {what}; {remedy}"
        )


def _require_space() -> None:
    free = shutil.disk_usage(own_folder()).free
    if free < _NEEDED:
        raise RosUnavailableError(
            f"the disk of '{own_folder()}' has {free / 1e9:.1f} GB free, and ROS 2 "
            f"needs {_NEEDED / 1e9:.1f} GB while it is installed; XDG_DATA_HOME names "
            "another folder"
        )


def _base_python() -> str:
    """Return the interpreter from which tool0's virtual environment was created."""
    return str(getattr(sys, "_base_executable", None) or sys.executable)


def _compilers() -> dict[str, str]:
    """Return the commands of the compilers, by environment variable."""
    return {
        variable: os.environ.get(variable, "").strip()
        or next((name for name in names if shutil.which(name)), names[0])
        for variable, names in _COMPILERS.items()
    }


# --- its parts ---


def _make(prefix: Path, progress: ProgressCallback) -> None:
    shutil.rmtree(prefix, ignore_errors=True)
    work = own_folder() / "work"
    work.mkdir()
    environment = {**plain_environment(os.environ), **_compilers(), "LC_ALL": "C.UTF-8"}
    python = str(own_python(prefix))
    try:
        progress("making a virtual environment", 0.0)
        _run([_base_python(), "-m", "venv", str(prefix)], environment, work)
        _install_wheels(python, environment, work, progress)
        packages = sorted(folder.name for folder in DEFINITIONS.iterdir())
        activity = f"compiling {', '.join(packages)}"

        def show(output: str) -> None:
            n_steps = generate.STEPS * len(packages)
            progress(activity, output.count("\n") / n_steps)

        program = [python, generate.__file__, str(DEFINITIONS), str(prefix), str(work)]
        _run(program, environment, work, show)
        _run([python, "-c", _CHECK, str(DEFINITIONS)], environment, work)
        mark_complete(prefix, distro=DISTRO, size=size_on_disk(prefix))
    finally:
        shutil.rmtree(work, ignore_errors=True)


def _install_wheels(
    python: str, environment: Mapping[str, str], work: Path, progress: ProgressCallback
) -> None:
    def show(output: str) -> None:
        n_found = len(re.findall(r"^\s*(?:Collecting|Requirement)", output, re.M))
        progress(f"installing {', '.join(WHEELS)}", min(n_found / _N_WHEELS, 1.0))

    options = ("--no-input", "--disable-pip-version-check", "--prefer-binary")
    command = [python, "-m", "pip", "install", *options, *WHEELS]
    try:
        _run(command, environment, work, show)
    except RosUnavailableError as error:
        for pattern, reason in _FAILURES.items():
            if re.search(pattern, str(error), re.IGNORECASE):
                raise RosUnavailableError(f"{reason}.\n{error}") from None
        raise


def _run(
    command: Sequence[str],
    environment: Mapping[str, str],
    work: Path,
    show: Callable[[str], None] = lambda output: None,
) -> None:
    """Run a program, and show its output as progress.

    Raises:
        RosUnavailableError: If the program fails.  The message contains the end of the
            program's output.
    """
    log = work / "output.txt"
    with (
        log.open("wb") as stream,
        ChildProcess(command, environment=environment, log=stream, grace=1.0) as child,
    ):
        while child.exit_status is None:
            show(log.read_text(encoding="utf-8", errors="replace"))
            with suppress(subprocess.TimeoutExpired):
                child.wait(_POLL_PERIOD)
    output = log.read_text(encoding="utf-8", errors="replace")
    if child.exit_status != 0:
        raise RosUnavailableError(
            f"`{shlex.join(command[:4])} …` failed:\n{last_lines(output, 12)}"
        )
    show(output)
