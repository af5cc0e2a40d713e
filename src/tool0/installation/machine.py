"""Looks up this machine's files, programs, package managers and Python packages."""

from __future__ import annotations

import os
import platform
import re
import shlex
import shutil
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, final

_INSTALL_COMMANDS: Final = {
    "apt-get": "sudo apt install",
    "dnf": "sudo dnf install",
    "zypper": "sudo zypper install",
    "pacman": "sudo pacman -S",
    "apk": "sudo apk add",
    "brew": "brew install",
    "winget": "winget install",
}


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Machine:
    """The machine that probes examine.  Tests pass another root folder."""

    root: Path = Path("/")
    environ: Mapping[str, str] = field(default_factory=lambda: os.environ)
    system: str = sys.platform

    def program(self, *names: str) -> str | None:
        """Return the path of the first program in ``names`` that is in PATH."""
        path = self.environ.get("PATH", "")
        found = (shutil.which(name, path=path) for name in names)
        return next((name for name in found if name), None)

    def install_command(self, apt: str, **others: str) -> str:
        """Return the command that installs a package, or an empty text.

        Args:
            apt: Name of the package on Debian and Ubuntu.  The name is also used for
                package managers that are not in ``others``.
            others: Name of the package by package manager; empty if the package manager
                does not offer the package.
        """
        for manager, command in _INSTALL_COMMANDS.items():
            if self.program(manager):
                package = others.get(manager, apt)
                return f"{command} {package}" if package else ""
        return ""

    def has_desktop(self) -> bool:
        """Return whether this user has a display on which windows can be opened."""
        if "SSH_CONNECTION" in self.environ and "DISPLAY" not in self.environ:
            return False
        if self.system in ("darwin", "win32"):
            return True
        return any(self.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))

    def read(self, name: str) -> str:
        """Return the text of a file, or an empty text if the file does not exist."""
        try:
            return (self.root / name).read_text(encoding="utf-8", errors="replace")
        except OSError:
            return ""

    def release(self) -> dict[str, str]:
        """Return the fields of ``os-release``."""
        text = self.read("etc/os-release") or self.read("usr/lib/os-release")
        fields = (line.strip().partition("=") for line in text.splitlines())
        return {key: value.strip("\"'") for key, _, value in fields if value}

    def name(self) -> str:
        """Return the name of the operating system."""
        if self.system == "linux":
            return self.release().get("PRETTY_NAME", "Linux")
        if self.system == "darwin":
            return f"macOS {platform.mac_ver()[0]}"
        return f"{platform.system()} {platform.release()}"

    def codename(self) -> str:
        """Return the codename of the release, such as ``bookworm``.

        For Mint, the result is the codename of the underlying Ubuntu release.
        """
        release = self.release()
        keys = ("UBUNTU_CODENAME", "DEBIAN_CODENAME", "VERSION_CODENAME")
        return next((release[key] for key in keys if key in release), "")


# --- the Python packages that tool0 needs ---


def python_requirements() -> dict[str, str]:
    """Return the requirement of each package, such as ``mujoco>=3.3``, by package.

    The result is empty if tool0 runs from a source folder.
    """
    # importing this module is slow, and it is rarely needed
    from importlib import metadata

    try:
        stated = metadata.requires("tool0") or []
    except metadata.PackageNotFoundError:
        return {}
    return {
        re.split(r"[^\w.-]", text, maxsplit=1)[0]: text
        for text in stated
        if ";" not in text
    }


def python_package_version(package: str) -> str | None:
    """Return the installed version of a package; None if it is not installed."""
    from importlib import metadata

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def pip_install_command(*arguments: str) -> str:
    """Return the pip command that installs packages for this Python."""
    return shlex.join([sys.executable, "-m", "pip", "install", *arguments])
