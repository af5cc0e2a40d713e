"""Whether a person sits before a desktop, where a browser can open."""

from __future__ import annotations

from collections.abc import Mapping


def has_desktop(environ: Mapping[str, str], system: str) -> bool:
    """Return whether a window would be seen; ``system`` is as ``sys.platform``."""
    if "SSH_CONNECTION" in environ and "DISPLAY" not in environ:
        return False
    if system in ("darwin", "win32"):
        return True
    return any(environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
