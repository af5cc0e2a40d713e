"""A probe of ``tool0 doctor``: whether the robot's cameras can draw."""

from __future__ import annotations

from typing import Final

from tool0.engines.mujoco.gl import PACKAGES, kind_of_context, make_context
from tool0.errors import RenderError
from tool0.installation.doctor.report import ProbeResult
from tool0.installation.machine import Machine

_MESA: Final = {
    "dnf": "mesa-libEGL mesa-dri-drivers",
    "zypper": "Mesa-libEGL1 Mesa-dri",
    "pacman": "mesa",
    "apk": "mesa-egl mesa-dri-gallium",
}


def cameras(examined: Machine) -> list[ProbeResult]:
    """Return whether pictures can be rendered, by making a context."""
    try:
        make_context(8, 8).free()
    except RenderError as error:
        remedy = examined.install_command(PACKAGES, **_MESA)
        return [ProbeResult("cameras", "missing", str(error), remedy)]
    found = f"draw without a window, by {kind_of_context()}"
    return [ProbeResult("cameras", "ready", found)]
