"""What draws and what shows: the panel, a browser, a desktop, a GPU, the cameras."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path
from typing import Final

from tool0.installation.doctor.line import Line
from tool0.installation.doctor.machine import Machine

_BROWSERS: Final = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable"),
    *("firefox", "firefox-esr", "microsoft-edge", "microsoft-edge-stable"),
    *("brave-browser", "vivaldi", "opera", "epiphany", "falkon"),
)
_OWN_BROWSER: Final = {"darwin": "Safari", "win32": "Microsoft Edge"}
_FIREFOX: Final = {
    "dnf": "firefox",
    "zypper": "MozillaFirefox",
    "pacman": "firefox",
    "apk": "firefox",
}
_MESA: Final = {
    "dnf": "mesa-libEGL mesa-dri-drivers",
    "zypper": "Mesa-libEGL1 Mesa-dri",
    "pacman": "mesa",
    "apk": "mesa-egl mesa-dri-gallium",
}
_UNREADABLE: Final = "; this account may not use it: after the command, log in again"
_VENDORS: Final = {"0x10de": "NVIDIA", "0x1002": "AMD", "0x8086": "Intel"}


def panel(here: Machine) -> list[Line]:
    """Tell whether the panel can be served."""
    from tool0.interfaces.panel.server import is_page_built, load

    load()
    if is_page_built():
        return [Line(what="panel", state="ready", found="its page is built")]
    found = "its page is not built: its address would show none"
    return [Line(what="panel", state="missing", found=found, remedy="make web")]


def browser(here: Machine) -> list[Line]:
    """Tell what shows the panel, and whether it is opened by itself."""
    from tool0.interfaces.panel.address import DEFAULT_PORT
    from tool0.interfaces.panel.desktop import has_desktop

    program = here.program(*_BROWSERS) or _OWN_BROWSER.get(here.system)
    if program is None:
        ubuntu = "ubuntu" in here.release().get("ID", "")
        return [
            Line(
                what="browser",
                state="missing",
                found="none here; another machine's shows the panel, too: "
                "tool0 bringup --panel-host 0.0.0.0",
                remedy=here.install("firefox" if ubuntu else "firefox-esr", **_FIREFOX),
            )
        ]
    how = f"no desktop: open http://127.0.0.1:{DEFAULT_PORT}/ in it yourself"
    if has_desktop(here.environ, here.system):
        how = "tool0 opens the panel in the desktop's own"
    return [Line(what="browser", state="ready", found=f"{program}; {how}")]


def gpu(here: Machine) -> list[Line]:
    """Tell which GPUs there are; nothing of tool0 needs one."""
    if here.system == "darwin":
        return [Line(what="gpu", state="ready", found="the Mac's own")]
    try:
        cards = [*_nvidia(here), *_rendering(here)]
    except subprocess.TimeoutExpired as error:
        found = f"{error.cmd[0]} does not answer: NVIDIA's driver hangs"
        return [Line(what="gpu", state="unknown", found=found)]
    if cards:
        blocked = [node for node in _nodes(here) if not os.access(node, os.R_OK)]
        remedy = 'sudo usermod -aG render "$USER"' if blocked else ""
        found = ", ".join(cards) + _UNREADABLE * bool(blocked)
        return [Line(what="gpu", state="ready", found=found, remedy=remedy)]
    found = "none, and none is needed: physics runs on the CPU, browsers draw on it"
    return [Line(what="gpu", state="missing", found=found)]


def cameras(here: Machine) -> list[Line]:
    """Tell whether the robot's cameras can draw, by trying it."""
    from tool0.engines.mujoco.gl import PACKAGES, kind_of_context, make_context
    from tool0.errors import RenderError

    try:
        make_context(8, 8).free()
    except RenderError as error:
        remedy = here.install(PACKAGES, **_MESA)
        return [Line(what="cameras", state="missing", found=str(error), remedy=remedy)]
    found = f"draw without a window, by {kind_of_context()}"
    return [Line(what="cameras", state="ready", found=found)]


def _nvidia(here: Machine) -> list[str]:
    """Ask the driver's files; nvidia-smi, which may hang, only where it has none."""
    files = sorted((here.root / "proc/driver/nvidia/gpus").glob("*/information"))
    models = (re.search(r"^Model:\s*(.+)$", file.read_text(), re.M) for file in files)
    cards = [model[1].strip() for model in models if model]
    stated = re.search(
        r"Kernel Module\D+([\d.]+)", here.read("proc/driver/nvidia/version")
    )
    if cards:
        return [*cards, f"driver {stated[1]}"] if stated else cards
    program = here.program("nvidia-smi")
    if program is None:
        return []
    fields = "--query-gpu=name,driver_version"
    try:
        answer = here.ask([program, fields, "--format=csv,noheader"])
    except (OSError, subprocess.CalledProcessError):
        return []  # it is installed, and no driver is
    return [line.replace(", ", ", driver ") for line in answer.splitlines() if line]


def _nodes(here: Machine) -> list[Path]:
    return sorted((here.root / "dev/dri").glob("renderD*"))


def _rendering(here: Machine) -> list[str]:
    """Return whose the nodes are that programs draw by."""
    vendors = (
        here.read(f"sys/class/drm/{node.name}/device/vendor").strip()
        for node in _nodes(here)
    )
    names = (_VENDORS.get(vendor, "a GPU") for vendor in vendors)
    return [f"{name} ({node})" for name, node in zip(names, _nodes(here), strict=True)]
