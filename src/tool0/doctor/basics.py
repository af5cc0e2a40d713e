"""The machine itself, its Python, and the simulation that everybody gets."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import re
import shlex
import sys

from tool0.doctor.line import Line
from tool0.doctor.machine import Machine

_OLDEST = (3, 10)


def machine(here: Machine) -> list[Line]:
    """Tell what the machine is."""
    n_cores = os.cpu_count() or 1
    parts = [
        here.name(),
        platform.machine(),
        f"{n_cores} core{'s' if n_cores > 1 else ''}",
        *_memory(here),
    ]
    return [Line(what="machine", state="ready", found=", ".join(parts))]


def python(here: Machine) -> list[Line]:
    """Tell which Python runs this, and whether it has what tool0 needs."""
    version = platform.python_version()
    where = f"{version}, {sys.prefix}"
    if sys.version_info < _OLDEST:
        return [
            Line(
                what="python",
                state="missing",
                found=f"{where}: tool0 needs Python 3.10 or later",
                remedy=here.install("python3 python3-venv"),
            )
        ]
    lacking = [text for text in _requirements() if _version(_name(text)) is None]
    if lacking:
        return [
            Line(
                what="python",
                state="missing",
                found=f"{where}: without {', '.join(map(_name, lacking))}",
                remedy=_pip(*lacking),
            )
        ]
    tool0 = _version("tool0") or "of unknown version"
    return [Line(what="python", state="ready", found=f"{where}, tool0 {tool0}")]


def mujoco(here: Machine) -> list[Line]:
    """Bring the robot up in MuJoCo, and let a little time pass."""
    import tool0

    try:
        with tool0.bringup(realtime=False) as robot:
            robot.run(0.01)
    except ImportError as error:
        broken = (error.name or "mujoco").partition(".")[0]
        wanted = next((t for t in _requirements() if _name(t) == broken), broken)
        return [
            Line(
                what="mujoco",
                state="missing",
                found=str(error),
                remedy=_pip("--force-reinstall", wanted),
            )
        ]
    version = _version("mujoco") or "of unknown version"
    found = f"{version}: the UR5 with its 2F-85 and their controllers run"
    return [Line(what="mujoco", state="ready", found=found)]


def _memory(here: Machine) -> list[str]:
    stated = re.search(r"^MemTotal:\s+(\d+) kB", here.read("proc/meminfo"), re.M)
    return [f"{int(stated[1]) * 1024 / 1e9:.0f} GB of memory"] if stated else []


def _pip(*words: str) -> str:
    return shlex.join([sys.executable, "-m", "pip", "install", *words])


def _requirements() -> list[str]:
    try:
        stated = importlib.metadata.requires("tool0") or []
    except importlib.metadata.PackageNotFoundError:  # run from a folder of sources
        return []
    return [text for text in stated if ";" not in text]


def _name(requirement: str) -> str:
    return re.split(r"[^\w.-]", requirement, maxsplit=1)[0]


def _version(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None
