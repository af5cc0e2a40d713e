"""The machine itself, its Python, and the simulation that everybody gets."""

from __future__ import annotations

import os
import platform
import re
import sys

from tool0.installation.doctor.dependencies import install, lacking, name_of, version
from tool0.installation.doctor.line import Line
from tool0.installation.doctor.machine import Machine


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
    where = f"{platform.python_version()}, {sys.prefix}"
    absent = lacking()
    if absent:
        return [
            Line(
                what="python",
                state="missing",
                found=f"{where}: without {', '.join(map(name_of, absent))}",
                remedy=install(*absent),
            )
        ]
    found = f"{where}, tool0 {version('tool0') or 'of unknown version'}"
    return [Line(what="python", state="ready", found=found)]


def mujoco(here: Machine) -> list[Line]:
    """Bring the robot up in MuJoCo, and let a little time pass."""
    import tool0

    with tool0.bringup(realtime=False) as robot:
        robot.run(0.01)
    stated = version("mujoco") or "of unknown version"
    found = f"{stated}: the UR5 with its 2F-85 and their controllers run"
    return [Line(what="mujoco", state="ready", found=found)]


def _memory(here: Machine) -> list[str]:
    stated = re.search(r"^MemTotal:\s+(\d+) kB", here.read("proc/meminfo"), re.M)
    return [f"{int(stated[1]) * 1024 / 1e9:.0f} GB of memory"] if stated else []
