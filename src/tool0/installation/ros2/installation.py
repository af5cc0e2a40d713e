"""Finds the ROS 2 to run: a sourced one, one in /opt/ros, or the one from tool0.

tool0 does not import ROS 2.  The node of tool0 runs under the Python of the ROS 2 that
is found, in the environment that this module returns.
"""

from __future__ import annotations

import json
import os
import re
import shutil
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Literal, final

from tool0.installation.child_process import run_program
from tool0.user_data import data_folder

SUPPORTED: Final = ("rolling", "lyrical", "kilted", "jazzy", "iron", "humble")
"""Supported distributions, with the newest first."""
OLDEST_PYTHON: Final = (3, 10)
SYSTEM_ROOT: Final = Path("/opt/ros")
NODE_FOLDER: Final = Path(__file__).parents[2] / "ros_packages" / "tool0_ros2"
"""Folder of tool0's node, which is added to PYTHONPATH."""
MARKER: Final = "tool0-ros2.json"
"""File that is written last into tool0's own installation.  An installation without
this file is incomplete."""
_FORMAT: Final = 1

_FOREIGN: Final = (
    *("VIRTUAL_ENV", "VIRTUAL_ENV_PROMPT", "PYTHONHOME", "__PYVENV_LAUNCHER__"),
    "_ROS_WHEELS_BOOTSTRAP_COMPLETE",
)
"""Variables of tool0's Python and of other wheels.  These variables would make another
Python use wrong folders."""
_ROS_VARIABLES: Final = (
    *("AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH", "COLCON_PREFIX_PATH", "PYTHONPATH"),
    *("LD_LIBRARY_PATH", "ROS_DISTRO", "ROS_VERSION", "ROS_PYTHON_VERSION"),
    *("ROS_ROOT", "ROS_PACKAGE_PATH", "ROS_ETC_DIR", "ROS_MASTER_URI"),
)
"""Environment variables that are set when a ROS is sourced."""
_RCLPY: Final = re.compile(r"python(3\.\d+)/(?:site|dist)-packages$")

_VERSION: Final = re.compile(r"<version[^>]*>\s*([^<\s]+)")

Kind = Literal["sourced", "system", "own"]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Ros2:
    """A ROS 2 installation that contains rclpy."""

    kind: Kind
    """Whether the ROS 2 was sourced in this terminal, found in /opt/ros, or installed
    by tool0."""
    distro: str
    """Name of the distribution, such as ``kilted``."""
    prefix: Path
    """The folder that contains rclpy's package."""
    python: Path
    """Path of the ROS 2's Python interpreter."""
    environment: dict[str, str] = field(repr=False)
    """All environment variables of a process that uses this ROS 2, without the node's
    path."""

    @property
    def origin(self) -> str:
        """Origin of this ROS 2, as text for users."""
        return {"system": "the system's", "own": "tool0's own"}.get(
            self.kind, "sourced"
        )

    @property
    def prefixes(self) -> list[Path]:
        """The folders of ROS packages.  The first folder takes precedence."""
        named = self.environment.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
        return [Path(name) for name in dict.fromkeys(named) if name]

    def version(self, package: str) -> str | None:
        """Return the version of a package; None if it is not installed."""
        for prefix in self.prefixes:
            manifest = prefix / "share" / package / "package.xml"
            with suppress(OSError):
                match = _VERSION.search(manifest.read_text(encoding="utf-8"))
                return match and match[1]
        return None


def find_ros2(environ: Mapping[str, str] | None = None) -> Ros2 | None:
    """Return the ROS 2 that tool0 would run; None if there is none.

    Args:
        environ: Environment variables of this process, including variables of a sourced
            ROS 2.
    """
    variables = dict(os.environ if environ is None else environ)
    return _sourced(variables) or _system(variables) or find_own(variables)


# --- a ROS 2 of its own packages ---


def _sourced(variables: dict[str, str]) -> Ros2 | None:
    """Return the ROS 2 whose setup file has been sourced in this terminal."""
    distro = variables.get("ROS_DISTRO", "")
    named = variables.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    prefixes = [Path(name) for name in named if name]
    if variables.get("ROS_VERSION", "2") != "2" or not (distro and prefixes):
        return None
    for prefix in prefixes:
        if prefix.joinpath(MARKER).is_file():  # set up by `tool0 ros2 env`
            return _own(prefix, variables)
    for prefix in prefixes:
        python = _python_of(prefix)
        if python is not None:
            return Ros2(
                kind="sourced",
                distro=distro,
                prefix=prefix,
                python=python,
                environment=_without_foreign(variables),
            )
    return None


def _system(variables: dict[str, str]) -> Ros2 | None:
    """Return the newest ROS 2 in /opt/ros."""
    for distro in SUPPORTED:
        prefix = SYSTEM_ROOT / distro
        python = _python_of(prefix)
        if python is not None and prefix.joinpath("setup.bash").is_file():
            return Ros2(
                kind="system",
                distro=distro,
                prefix=prefix,
                python=python,
                environment=_after_setup(prefix / "setup.bash", variables),
            )
    return None


def _python_of(prefix: Path) -> Path | None:
    """Return the Python that can import rclpy of the ROS 2 in ``prefix``, or None."""
    for pattern in ("lib/python3*/site-packages", "local/lib/python3*/dist-packages"):
        for folder in sorted(prefix.glob(pattern)):
            match = _RCLPY.search(folder.as_posix())
            if match is None or not folder.joinpath("rclpy").is_dir():
                continue
            if tuple(int(part) for part in match[1].split(".")) < OLDEST_PYTHON:
                continue
            name = f"python{match[1]}"
            for candidate in (prefix / "bin" / name, Path("/usr/bin", name)):
                if candidate.is_file():
                    return candidate
            found = shutil.which(name)
            return None if found is None else Path(found)
    return None


def _after_setup(setup: Path, variables: dict[str, str]) -> dict[str, str]:
    """Return the environment after the setup file is sourced in a shell."""
    before = plain_environment(variables)
    answer = run_program(
        ["bash", "-c", '. "$0" >&2 && env -0', str(setup)], environment=before
    )
    pairs = (line.partition("=") for line in answer.stdout.split("\0") if line)
    return {name: value for name, _, value in pairs if name not in ("_", "SHLVL")}


def _without_foreign(variables: Mapping[str, str]) -> dict[str, str]:
    """Return the variables without tool0's virtual environment."""
    kept = {name: text for name, text in variables.items() if name not in _FOREIGN}
    venv = variables.get("VIRTUAL_ENV")
    if venv:
        path = kept.get("PATH", os.defpath).split(os.pathsep)
        programs = str(Path(venv, "bin"))
        kept["PATH"] = os.pathsep.join(entry for entry in path if entry != programs)
    return kept


def plain_environment(variables: Mapping[str, str]) -> dict[str, str]:
    """Return the variables for a process with another Python and without any ROS."""
    kept = _without_foreign(variables)
    return {name: text for name, text in kept.items() if name not in _ROS_VARIABLES}


# --- tool0's own ---


def own_folder() -> Path:
    """Return the folder of tool0's own installations.  The folder may not exist."""
    return data_folder() / "ros2"


def current_link() -> Path:
    """Return the path of the link to the selected installation."""
    return own_folder() / "current"


def find_own(environ: Mapping[str, str] | None = None) -> Ros2 | None:
    """Return the ROS 2 from ``tool0 ros2 install``; None if it is incomplete."""
    prefix = current_link().resolve()
    return _own(prefix, os.environ if environ is None else environ)


def _own(prefix: Path, variables: Mapping[str, str]) -> Ros2 | None:
    marker = read_marker(prefix)
    if marker is None:
        return None
    environment = plain_environment(variables)
    if environment.get("RMW_IMPLEMENTATION") != "rmw_fastrtps_cpp":
        # this installation contains only rmw_fastrtps_cpp
        environment.pop("RMW_IMPLEMENTATION", None)
    programs = str(prefix / "bin")
    path = environment.get("PATH", os.defpath).split(os.pathsep)
    path = [programs, *(entry for entry in path if entry != programs)]
    environment |= {
        "PATH": os.pathsep.join(path),
        "AMENT_PREFIX_PATH": str(prefix),
        "ROS_DISTRO": marker["distro"],
        "ROS_VERSION": "2",
        "ROS_PYTHON_VERSION": "3",
    }
    return Ros2(
        kind="own",
        distro=marker["distro"],
        prefix=prefix,
        python=own_python(prefix),
        environment=environment,
    )


def own_python(prefix: Path) -> Path:
    """Return the path of Python in tool0's own installation."""
    return prefix / "bin" / "python"


def read_marker(prefix: Path) -> dict[str, Any] | None:
    """Return the marker of tool0's own installation; None if it is incomplete."""
    try:
        marker: dict[str, Any] = json.loads((prefix / MARKER).read_bytes())
        if marker["format"] != _FORMAT or not isinstance(marker["distro"], str):
            return None
    except (OSError, ValueError, TypeError, KeyError):
        return None
    # The Python is a link to the interpreter from which it was created.  The original
    # interpreter may have been removed.
    return marker if own_python(prefix).is_file() else None


def mark_complete(prefix: Path, *, distro: str, size: int) -> None:
    """Write the marker of a complete installation.

    Args:
        prefix: The folder of the installation.
        distro: Name of the distribution, such as ``kilted``.
        size: Size of the installation on disk [bytes].
    """
    marker = {"format": _FORMAT, "distro": distro, "size": size}
    (prefix / MARKER).write_text(f"{json.dumps(marker)}\n", encoding="utf-8")
