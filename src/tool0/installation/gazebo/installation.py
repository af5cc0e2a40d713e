"""Finds the Gazebo to run: a selected, a system or a private installation.

All installations have the same folder layout.  An installation is the root of a system
(``/usr``, ``/usr/local``) or the result of ``tool0 gazebo install``.  The result of
``tool0 gazebo install`` is a root in another folder.  Environment variables give the
paths of this root to the linker, the drivers and Qt.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, final

from tool0.errors import EngineUnavailableError
from tool0.installation.child_process import run_program
from tool0.user_data import data_folder, expanded

NAMED_BY: Final = "TOOL0_GAZEBO"
"""Environment variable that selects a prefix or a root such as ``/usr``."""
_ADVICE: Final = "install one: tool0 gazebo install"
MARKER: Final = "tool0-gazebo.json"
"""File that is written last into a private prefix.  A folder without this file is
incomplete."""
_FORMAT: Final = 1
_HEADER: Final = Path("include", "gazebo-11", "gazebo", "gazebo_config.h")
_VERSION: Final = re.compile(r'GAZEBO_VERSION_FULL\s+"([^"]+)"')


@final
@dataclass(frozen=True, slots=True)
class GazeboInstallation:
    """A working Gazebo 11, with the headers that are needed to compile a plugin."""

    version: str
    """Version of Gazebo, such as ``11.1.0``."""
    prefix: Path | None
    """The private prefix; None for the system's Gazebo."""
    server: Path
    """Path of the program gzserver."""
    client: Path | None
    """Path of the program gzclient; None if it cannot run."""
    environment: dict[str, str]
    """Additional environment variables for both programs."""
    include_dirs: tuple[Path, ...]
    """Folders in which the compiler finds the headers."""
    size: int | None = None
    """Size of the private prefix on disk [bytes]; None for the system's Gazebo."""


def private_prefix() -> Path:
    """Return the folder of ``tool0 gazebo install``.  The folder may not exist."""
    return data_folder() / "gazebo" / "prefix"


def find_installation() -> GazeboInstallation:
    """Return the Gazebo that tool0 would run.

    Raises:
        EngineUnavailableError: If there is no Gazebo.  The message contains the command
            that installs Gazebo.
    """
    named = os.environ.get(NAMED_BY)
    if named:
        root = expanded(named).absolute()
        found = from_prefix(root) or from_root(root)
        if found is None:
            raise EngineUnavailableError(
                f"{NAMED_BY} is '{named}', which has no complete Gazebo 11: it is "
                "not from `tool0 gazebo install`, and lacks bin/gzserver or its headers"
            )
        return found
    found = find_system() or from_prefix(private_prefix())
    if found is None:
        raise EngineUnavailableError(_why_none())
    return found


def find_system() -> GazeboInstallation | None:
    """Return the system's Gazebo 11; None if it or its headers are missing."""
    server = shutil.which("gzserver")
    return None if server is None else from_root(Path(server).parent.parent)


def from_prefix(prefix: Path) -> GazeboInstallation | None:
    """Return the Gazebo in a private prefix; None if the prefix is incomplete."""
    try:
        marker: dict[str, Any] = json.loads((prefix / MARKER).read_bytes())
        if marker["format"] != _FORMAT:
            return None
        version, has_client = str(marker["version"]), bool(marker["has_client"])
        triplet, size = str(marker["triplet"]), int(marker["size"])
    except (OSError, ValueError, TypeError, KeyError):
        return None
    programs = prefix / "usr" / "bin"
    client = programs / f"gzclient-{version}"
    return GazeboInstallation(
        version=version,
        prefix=prefix,
        server=programs / f"gzserver-{version}",
        client=client if has_client else None,
        environment=_private_environment(prefix, triplet, has_client=has_client),
        include_dirs=include_folders(prefix / "usr"),
        size=size,
    )


def mark_complete(prefix: Path, *, triplet: str, has_client: bool, size: int) -> None:
    """Write the marker of a complete private prefix.

    Args:
        prefix: The private prefix.
        triplet: Name of the prefix's library folder, such as ``x86_64-linux-gnu``.
        has_client: Whether the prefix contains Qt and a rendering driver, so that
            gzclient can run.
        size: Size of the prefix on disk [bytes].

    Raises:
        EngineUnavailableError: If the prefix does not contain Gazebo's headers.
    """
    version = _header_version(prefix / "usr")
    if version is None:
        raise EngineUnavailableError(f"'{prefix}' has no header of Gazebo 11")
    marker = {"format": _FORMAT, "version": version, "triplet": triplet}
    marker |= {"has_client": has_client, "size": size}
    (prefix / MARKER).write_text(f"{json.dumps(marker)}\n", encoding="utf-8")


def from_root(root: Path) -> GazeboInstallation | None:
    """Return the Gazebo 11 under ``root``; None if it or its headers are missing."""
    server, client = root / "bin" / "gzserver", root / "bin" / "gzclient"
    version = _header_version(root)
    if version is None or not version.startswith("11.") or not server.is_file():
        return None
    return GazeboInstallation(
        version=version,
        prefix=None,
        server=server,
        client=client if client.is_file() else None,
        environment=_gazebo_paths(root),
        include_dirs=include_folders(root),
    )


def _why_none() -> str:
    server = shutil.which("gzserver")
    if server is None:
        return f"there is no Gazebo 11 here; {_ADVICE}"
    version = _stated_version(server)
    if version is not None and version.startswith("11."):
        return (
            f"Gazebo {version} ('{server}') lacks its headers; install "
            "them (apt install libgazebo-dev), or another Gazebo: tool0 gazebo install"
        )
    stated = "prints no version" if version is None else f"is Gazebo {version}, not 11"
    return f"'{server}' {stated}; {_ADVICE}"


def _stated_version(server: str) -> str | None:
    try:  # loading the libraries of gzserver takes some time
        answer = run_program([server, "--version"], timeout=30.0)
    except subprocess.TimeoutExpired:
        return None
    words = answer.stdout.partition("version")[2].split()
    return words[0] if words else None


def _header_version(root: Path) -> str | None:
    """Return the version in Gazebo's headers under ``root``; None if it is missing."""
    try:
        match = _VERSION.search((root / _HEADER).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError):
        return None
    return None if match is None else match.group(1)


def include_folders(root: Path) -> tuple[Path, ...]:
    """Return the folders of Gazebo's headers and of the headers that they include.

    ``/usr/include`` is never returned.  If ``/usr/include`` were given explicitly, it
    would come before the compiler's own headers, and the compiler's headers would not
    find the C library's headers.
    """
    include = root / "include"
    folders = [include / "gazebo-11"]
    for base in dict.fromkeys((include, Path("/usr/include"))):
        if not folders[1:]:  # both header folders are in the same root
            folders += [*base.glob("sdformat-9*"), *base.glob("ignition/*[0-9]")]
    if include != Path("/usr/include"):
        folders.append(include)
    return tuple(folders)


def _gazebo_paths(root: Path) -> dict[str, str]:
    """Return the variables for Gazebo's paths, as Gazebo's ``setup.sh`` sets them.

    The current values of the variables come first.
    """
    share, default = root / "share" / "gazebo-11", root / "lib" / "gazebo-11"
    plugins = next((p for p in root.glob("lib/*/gazebo-11") if p.is_dir()), default)
    paths = {
        "GAZEBO_RESOURCE_PATH": _appended("GAZEBO_RESOURCE_PATH", share),
        "GAZEBO_MODEL_PATH": _appended("GAZEBO_MODEL_PATH", share / "models"),
        "GAZEBO_PLUGIN_PATH": _appended("GAZEBO_PLUGIN_PATH", plugins / "plugins"),
        # Without this setting, the server waits for a web site of models, which may be
        # unreachable.
        "GAZEBO_MODEL_DATABASE_URI": os.environ.get("GAZEBO_MODEL_DATABASE_URI", ""),
    }
    ogre = next(iter(sorted(plugins.parent.glob("OGRE-1.*"))), None)
    return paths if ogre is None else {**paths, "OGRE_RESOURCE_PATH": str(ogre)}


def _private_environment(
    prefix: Path, triplet: str, *, has_client: bool
) -> dict[str, str]:
    """Return the variables that the programs of a private prefix need."""
    usr = prefix / "usr"
    lib = usr / "lib" / triplet
    libraries = [
        lib,
        usr / "lib",  # contains libgdal
        # links to these libraries are created by installing, but not by unpacking
        lib / "blas",
        lib / "lapack",
        lib / "pulseaudio",
        prefix / "lib" / triplet,
        lib / "gazebo-11" / "plugins",
    ]
    own = os.environ.get("LD_LIBRARY_PATH", "").split(":")
    # With a display but without a rendering driver, gzserver would end immediately.
    display = {} if has_client else {"DISPLAY": ""}
    return {
        **_gazebo_paths(usr),
        "LD_LIBRARY_PATH": ":".join([*map(str, libraries), *filter(None, own)]),
        "SDF_PATH": f"{usr}/share/sdformat9",
        "QT_PLUGIN_PATH": f"{lib}/qt5/plugins",
        "QT_QPA_PLATFORM_PLUGIN_PATH": f"{lib}/qt5/plugins/platforms",
        "LIBGL_DRIVERS_PATH": f"{lib}/dri",
        "__EGL_VENDOR_LIBRARY_DIRS": f"{usr}/share/glvnd/egl_vendor.d",
        "LIBGL_ALWAYS_SOFTWARE": "1",
        "FONTCONFIG_PATH": f"{prefix}/etc/fonts",
        "XKB_CONFIG_ROOT": f"{usr}/share/X11/xkb",
        "PROJ_LIB": f"{usr}/share/proj",
        # tool0 does not use sound.  The search for a sound device takes time and fills
        # the log.
        "ALSOFT_DRIVERS": os.environ.get("ALSOFT_DRIVERS", "null"),
        **display,
    }


def _appended(variable: str, folder: Path) -> str:
    own = os.environ.get(variable, "").strip(":")
    return f"{own}:{folder}" if own else str(folder)
