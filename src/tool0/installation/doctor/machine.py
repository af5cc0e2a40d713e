"""The machine that is looked at: its files, its programs, and who installs what."""

from __future__ import annotations

import os
import platform
import shlex
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, final

_MANAGERS: Final = {
    "apt-get": "sudo apt install",
    "dnf": "sudo dnf install",
    "zypper": "sudo zypper install",
    "pacman": "sudo pacman -S",
    "apk": "sudo apk add",
    "brew": "brew install",
    "winget": "winget install",
}
PATIENCE: Final = 2.0
"""Wall seconds that another's program may take."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Machine:
    """Where a probe looks; a test gives it another root."""

    root: Path = Path("/")
    environ: Mapping[str, str] = field(default_factory=lambda: os.environ)
    system: str = sys.platform

    def program(self, *names: str) -> str | None:
        """Return the path of the first of these programs that PATH has."""
        path = self.environ.get("PATH", "")
        found = (shutil.which(name, path=path) for name in names)
        return next((name for name in found if name), None)

    def install(self, apt: str, **others: str) -> str:
        """Return the command that installs a package.

        Args:
            apt: Its name for Debian and Ubuntu, and elsewhere if not among ``others``.
            others: Program → its name for this package; an empty one is not packaged.
        """
        for manager, command in _MANAGERS.items():
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
        """Return what ``/etc/os-release`` says."""
        words = (
            line.partition("=") for line in self.read("etc/os-release").split("\n")
        )
        return {key: _unquoted(value) for key, _, value in words if value}

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

    def ask(self, command: Sequence[str]) -> str:
        """Return what another's program prints.

        Raises:
            OSError: If it cannot be run.
            subprocess.SubprocessError: If it fails, or does not end in time.
        """
        return subprocess.run(
            command,
            env={**self.environ, "LC_ALL": "C"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            errors="replace",
            timeout=PATIENCE,
            check=True,
        ).stdout


def _unquoted(value: str) -> str:
    try:
        return " ".join(shlex.split(value))
    except ValueError:  # a quote that nothing closes
        return value
