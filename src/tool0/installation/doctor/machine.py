"""The machine that is examined: its files, programs and package managers."""

from __future__ import annotations

import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
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
PROGRAM_TIMEOUT: Final = 2.0
"""For programs of others [wall s]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ExaminedMachine:
    """Where a probe looks; a test passes another root."""

    root: Path = Path("/")
    environ: Mapping[str, str] = field(default_factory=lambda: os.environ)
    system: str = sys.platform

    def program(self, *names: str) -> str | None:
        """Return the path of the first of these programs that PATH has."""
        path = self.environ.get("PATH", "")
        found = (shutil.which(name, path=path) for name in names)
        return next((name for name in found if name), None)

    def install_command(self, apt: str, **others: str) -> str:
        """Return the command that installs a package; empty if there is none.

        Args:
            apt: Its name for Debian and Ubuntu, and elsewhere if not among ``others``.
            others: Package manager → its name there; empty if it is not packaged.
        """
        for manager, command in _INSTALL_COMMANDS.items():
            if self.program(manager):
                package = others.get(manager.replace("-", "_"), apt)
                return f"{command} {package}" if package else ""
        return ""

    def read(self, name: str) -> str:
        """Return the text of a file, empty if there is none."""
        try:
            return (self.root / name).read_text(encoding="utf-8", errors="replace")
        except OSError:
            return ""

    def release(self) -> dict[str, str]:
        """Return the fields of ``/etc/os-release``."""
        lines = self.read("etc/os-release").split("\n")
        fields = (line.partition("=") for line in lines)
        return {key: _unquoted(value) for key, _, value in fields if value}

    def name(self) -> str:
        """Return the operating system, for people."""
        if self.system == "linux":
            return self.release().get("PRETTY_NAME", "Linux")
        if self.system == "darwin":
            return f"macOS {platform.mac_ver()[0]}"
        return f"{platform.system()} {platform.release()}"

    def codename(self) -> str:
        """Return the release's codename, as ``bookworm``; Mint's is its Ubuntu's."""
        release = self.release()
        keys = ("UBUNTU_CODENAME", "DEBIAN_CODENAME", "VERSION_CODENAME")
        return next((release[key] for key in keys if key in release), "")

    def output_of(self, command: Sequence[str]) -> str:
        """Return what a program prints.

        Raises:
            OSError: If it cannot be run.
            subprocess.SubprocessError: If it fails, or exceeds the timeout.
        """
        return subprocess.run(
            command,
            env={**self.environ, "LC_ALL": "C"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            errors="replace",
            timeout=PROGRAM_TIMEOUT,
            check=True,
        ).stdout


def _unquoted(value: str) -> str:
    try:
        return " ".join(shlex.split(value))
    except ValueError:  # a quote that nothing closes
        return value


# --- the Python packages that tool0 needs ---


def python_requirements() -> list[str]:
    """Return what tool0 requires, as ``mujoco>=3.3``; nothing for a source folder."""
    from importlib import metadata  # slow, and mostly not needed

    try:
        stated = metadata.requires("tool0") or []
    except metadata.PackageNotFoundError:
        return []
    return [text for text in stated if ";" not in text]


def required_package(requirement: str) -> str:
    """Return the name of the package that a requirement is for."""
    return re.split(r"[^\w.-]", requirement, maxsplit=1)[0]


def python_package_version(package: str) -> str | None:
    """Return the version that is installed, None if none is."""
    from importlib import metadata

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def pip_install_command(*arguments: str) -> str:
    """Return the command that installs packages for the Python that runs this."""
    return shlex.join([sys.executable, "-m", "pip", "install", *arguments])
