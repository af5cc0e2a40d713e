"""A probe of ``tool0 doctor``: whether the robot runs in MuJoCo."""

from __future__ import annotations

from tool0.api.bringup import bringup
from tool0.installation.doctor.report import ProbeResult
from tool0.installation.machine import Machine, python_package_version


def mujoco(_: Machine) -> list[ProbeResult]:
    """Bring the robot up in MuJoCo, and run it for 10 ms."""
    with bringup(realtime=False) as robot:
        robot.run(0.01)
    version = python_package_version("mujoco") or "of unknown version"
    found = f"{version}: the UR5 with its 2F-85 and their controllers run"
    return [ProbeResult("mujoco", "ready", found)]
