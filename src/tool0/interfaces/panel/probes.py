"""Probes of ``tool0 doctor``: the panel's server, and a browser for it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from tool0.installation.doctor.report import ProbeResult
from tool0.installation.machine import Machine
from tool0.interfaces.panel.address import DEFAULT_PORT

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


def panel(_: Machine) -> list[ProbeResult]:
    """Return whether the panel can be served."""
    from tool0.interfaces.panel.server import is_page_built, load

    load()
    if is_page_built():
        return [ProbeResult("panel", "ready", "its page is built")]
    found = "its page is not built: its address would show none"
    return [ProbeResult("panel", "missing", found, "make web")]


def browser(examined: Machine) -> list[ProbeResult]:
    """Return which browser shows the panel, and whether it opens automatically."""
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
    if has_desktop(examined.environ, examined.system):
        how = "tool0 opens the panel in the desktop's own"
    return [ProbeResult("browser", "ready", f"{program}; {how}")]


def has_desktop(environ: Mapping[str, str], system: str) -> bool:
    """Return whether a person would see a window; ``system`` as ``sys.platform``."""
    if "SSH_CONNECTION" in environ and "DISPLAY" not in environ:
        return False
    if system in ("darwin", "win32"):
        return True
    return any(environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
