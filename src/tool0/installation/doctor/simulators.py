"""Gazebo, as an engine of tool0 and as the native one of ROS 1."""

from __future__ import annotations

from typing import Final

from tool0.installation.doctor.line import Line
from tool0.installation.doctor.machine import Machine

_INSTALL: Final = "tool0 gazebo install"


def gazebo(here: Machine) -> list[Line]:
    """Tell which Gazebo ``--engine gazebo`` runs, and whether it has a window."""
    if here.system != "linux":
        found = f"by tool0 on {here.name()}: Gazebo 11 runs on Linux"
        return [Line(what="gazebo", state="not supported", found=found)]
    from tool0.installation.gazebo.readiness import readiness

    there = readiness()
    if not there.can_run:
        compiler = here.install("g++", dnf="gcc-c++", zypper="gcc-c++", pacman="gcc")
        return [
            Line(
                what="gazebo",
                state="missing",
                found="; ".join(there.missing),
                remedy=compiler if there.version else f"{_INSTALL} --gui",
            )
        ]
    whose = "the system's" if there.prefix is None else "tool0's own"
    made = "" if there.is_compiled else ", its bridge compiled at the first start"
    found = f"{there.version}, {whose}, {there.server}{made}"
    window = Line(what="gazebo window", state="ready", found=str(there.client))
    if there.client is None:
        window = Line(
            what="gazebo window",
            state="missing",
            found="no gzclient, for --gazebo-gui",
            remedy=f"{_INSTALL} --gui --private",
        )
    return [Line(what="gazebo", state="ready", found=found), window]
