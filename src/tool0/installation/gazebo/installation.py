"""Which Gazebo would run: the one that is named, the system's, or the private one."""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

from tool0.errors import EngineUnavailableError
from tool0.installation.gazebo.prefix import (
    gazebo_paths,
    header_version,
    include_folders,
    private_environment,
    read_marker,
)
from tool0.user_data import data_folder

NAMED_BY: Final = "TOOL0_GAZEBO"
"""The variable that names a prefix, or a root such as ``/usr``, to take it alone."""
_ADVICE: Final = "install one: tool0 gazebo install"


@final
@dataclass(frozen=True, slots=True)
class Installation:
    """A Gazebo 11 that can run, and against which a plugin can be compiled."""

    version: str
    """As ``11.1.0``."""
    prefix: Path | None
    """The private prefix; None for a system's Gazebo."""
    server: Path
    """The program gzserver."""
    client: Path | None
    """The program gzclient, if it can run."""
    environment: dict[str, str]
    """Variables for both programs, on top of what the process has."""
    include_dirs: tuple[Path, ...]
    """Where the compiler finds the headers."""


def private_prefix() -> Path:
    """Return where ``tool0 gazebo install`` makes a Gazebo; it may not be there."""
    return data_folder() / "gazebo" / "prefix"


def find_installation() -> Installation:
    """Return the Gazebo that would run.

    Raises:
        EngineUnavailableError: If there is none; it says which command gets one.
    """
    named = os.environ.get(NAMED_BY)
    if named:
        root = Path(named).expanduser().absolute()
        found = from_prefix(root) or from_root(root)
        if found is None:
            raise EngineUnavailableError(
                f"{NAMED_BY} names '{named}', which has no whole Gazebo 11: neither "
                "made by `tool0 gazebo install` nor with bin/gzserver and its headers"
            )
        return found
    found = find_system() or from_prefix(private_prefix())
    if found is None:
        raise EngineUnavailableError(_why_none())
    return found


def find_system() -> Installation | None:
    """Return the system's Gazebo 11, if it has one, headers included."""
    server = shutil.which("gzserver")
    return None if server is None else from_root(Path(server).parent.parent)


def from_prefix(prefix: Path) -> Installation | None:
    """Return the Gazebo in a private prefix, if it is whole."""
    marker = read_marker(prefix)
    if marker is None:
        return None
    programs = prefix / "usr" / "bin"
    client = programs / f"gzclient-{marker.version}"
    return Installation(
        version=marker.version,
        prefix=prefix,
        server=programs / f"gzserver-{marker.version}",
        client=client if marker.has_client else None,
        environment=private_environment(prefix, marker),
        include_dirs=include_folders(prefix / "usr"),
    )


def from_root(root: Path) -> Installation | None:
    """Return the Gazebo 11 installed under ``root``, if it and its headers are."""
    server, client = root / "bin" / "gzserver", root / "bin" / "gzclient"
    version = header_version(root)
    if version is None or not version.startswith("11.") or not server.is_file():
        return None
    return Installation(
        version=version,
        prefix=None,
        server=server,
        client=client if client.is_file() else None,
        environment=gazebo_paths(root),
        include_dirs=include_folders(root),
    )


def _why_none() -> str:
    server = shutil.which("gzserver")
    if server is None:
        return f"there is no Gazebo 11 here; {_ADVICE}"
    version = _stated_version(server)
    if version is not None and version.startswith("11."):
        return (
            f"Gazebo {version} is here ('{server}') but not its headers; install "
            "them (apt install libgazebo-dev), or another Gazebo: tool0 gazebo install"
        )
    stated = "tells no version" if version is None else f"is Gazebo {version}, not 11"
    return f"'{server}' {stated}; {_ADVICE}"


def _stated_version(server: str) -> str | None:
    """Ask the program itself: it takes a while to load its libraries."""
    try:
        answer = subprocess.run(
            [server, "--version"],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=30,
            check=False,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    words = answer.stdout.partition("version")[2].split()
    return words[0] if words else None
