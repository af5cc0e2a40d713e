"""The probes of ``tool0 doctor`` for tool0's own packages, and the list of all probes.

A probe runs in a separate process and imports its package there.  Therefore, the import
of this module is fast, and a library that cannot be imported affects only one probe.
"""

from __future__ import annotations

import os
import socket
from typing import Final

from tool0.installation.doctor import probes
from tool0.installation.doctor.report import Probe, ProbeResult
from tool0.installation.machine import (
    Machine,
    pip_install_command,
    python_package_version,
)

_MESA: Final = {
    "dnf": "mesa-libEGL mesa-dri-drivers",
    "zypper": "Mesa-libEGL1 Mesa-dri",
    "pacman": "mesa",
    "apk": "mesa-egl mesa-dri-gallium",
}
_BROWSERS: Final = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable"),
    *("firefox", "firefox-esr", "microsoft-edge", "microsoft-edge-stable"),
    *("brave-browser", "vivaldi", "opera", "epiphany", "falkon"),
)
_BUILT_IN_BROWSER: Final = {"darwin": "Safari", "win32": "Microsoft Edge"}
_FIREFOX: Final = {
    "dnf": "firefox",
    "zypper": "MozillaFirefox",
    "pacman": "firefox",
    "apk": "firefox",
}
UR_PORTS: Final = (29999, 30001, 30002, 30003, 30004, 63352)
"""The ports that every client of a UR or its gripper expects."""


def mujoco(_: Machine) -> list[ProbeResult]:
    """Bring the robot up in MuJoCo, and run it for 10 ms."""
    from tool0.api.bringup import bringup

    with bringup(realtime=False) as robot:
        robot.run(0.01)
    version = python_package_version("mujoco") or "of unknown version"
    found = f"{version}: the UR5 with its 2F-85 and their controllers run"
    return [ProbeResult("mujoco", "ready", found)]


def kernel(examined: Machine) -> list[ProbeResult]:
    """Return the state of the compiled kernel, and how to compile a missing kernel."""
    from tool0.kernel import build, library

    if examined.system == "win32":
        found = "by tool0 on Windows: control runs in Python, more slowly"
        return [ProbeResult("kernel", "not supported", found)]
    status = library.kernel_status()
    if status.library is not None:
        return [ProbeResult("kernel", "ready", f"compiled, {status.path}")]
    found = f"Python only, which is slower: {status.reason}"
    if examined.environ.get(library.VARIABLE):
        remedy = f"unset {library.VARIABLE}"
        return [ProbeResult("kernel", "missing", found, remedy)]
    remedy = library.COMPILE_COMMAND
    try:
        build.find_compiler()
    except build.KernelBuildError as error:
        if examined.environ.get("CC"):
            found, remedy = f"{found}; {error}", "unset CC"
        else:
            found, remedy = f"{found}; no C compiler", f"{remedy} --install-compiler"
    if not os.access(status.path.parent, os.W_OK):
        found += f"; '{status.path.parent}' is read-only for this account"
    return [ProbeResult("kernel", "missing", found, remedy)]


def panel(_: Machine) -> list[ProbeResult]:
    """Return whether the panel can be served."""
    from tool0.panel.server import is_page_built, load

    load()
    if is_page_built():
        return [ProbeResult("panel", "ready", "its page is built")]
    found = "the panel's page is not built, so its address would show nothing"
    return [ProbeResult("panel", "missing", found, "make web")]


def browser(examined: Machine) -> list[ProbeResult]:
    """Return the browser that shows the panel, and whether it opens automatically."""
    from tool0.panel.address import DEFAULT_PORT

    program = examined.program(*_BROWSERS) or _BUILT_IN_BROWSER.get(examined.system)
    if program is None:
        is_ubuntu = "ubuntu" in examined.release().get("ID", "")
        apt = "firefox" if is_ubuntu else "firefox-esr"
        found = (
            "none here; another machine's shows the panel, too: "
            "tool0 bringup --panel-host 0.0.0.0"
        )
        remedy = examined.install_command(apt, **_FIREFOX)
        return [ProbeResult("browser", "missing", found, remedy)]
    how = f"no desktop: open http://127.0.0.1:{DEFAULT_PORT}/ in it yourself"
    if examined.has_desktop():
        how = "tool0 opens the panel in the desktop's own"
    return [ProbeResult("browser", "ready", f"{program}; {how}")]


def cameras(examined: Machine) -> list[ProbeResult]:
    """Return whether rendering works, by creating a rendering context."""
    from tool0.engines.mujoco.gl import PACKAGES, kind_of_context, make_context
    from tool0.errors import RenderError

    try:
        make_context(8, 8).free()
    except RenderError as error:
        remedy = examined.install_command(PACKAGES, **_MESA)
        return [ProbeResult("cameras", "missing", str(error), remedy)]
    found = f"draw without a window, by {kind_of_context()}"
    return [ProbeResult("cameras", "ready", found)]


def ur(_: Machine) -> list[ProbeResult]:
    """Return whether URScript can be parsed, and whether the UR's ports are free."""
    from tool0.ur.options import UrOptions

    host = UrOptions().host
    used = [str(port) for port in UR_PORTS if not _is_free(host, port)]
    ports = f"the ports of a UR at {host} are free"
    if used:
        ports = (
            f"in use at {host}: {', '.join(used)}; choose others by --ur-host or "
            "--ur-port-base"
        )
    version = python_package_version("lark")
    if version is None:
        found = f"no lark, which reads URScript; {ports}"
        return [ProbeResult("ur", "missing", found, pip_install_command("lark"))]
    return [ProbeResult("ur", "ready", f"lark {version}; {ports}")]


def _is_free(host: str, port: int) -> bool:
    with socket.socket() as connection:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            connection.bind((host, port))
        except OSError:
            return False
    return True


PROBES: Final = (
    Probe(probes.machine),
    Probe(probes.python, is_needed=True),
    Probe(mujoco, is_needed=True),
    Probe(kernel),
    Probe(panel),
    Probe(browser),
    Probe(probes.gpu),
    Probe(cameras),
    Probe(probes.gazebo),
    Probe(probes.ros1),
    Probe(probes.ros2),
    Probe(ur),
    Probe(probes.workspace),
)
"""The probes of ``tool0 doctor``, in the order of the report."""
