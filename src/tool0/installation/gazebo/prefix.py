"""A folder with a Gazebo 11 in it: what lies where, and the environment it needs.

Two kinds have the same shape: the root of a system (``/usr``, ``/usr/local``) and what
``tool0 gazebo install`` unpacked, which is a root within a folder that no linker,
driver or Qt knows of, and so has to be told to them by variables.
"""

from __future__ import annotations

import json
import os
import re
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final, final

MARKER: Final = "tool0-gazebo.json"
"""Written last into a private prefix: a folder without it is not finished."""
_FORMAT: Final = 1
_HEADER: Final = Path("include", "gazebo-11", "gazebo", "gazebo_config.h")
_VERSION: Final = re.compile(r'GAZEBO_VERSION_FULL\s+"([^"]+)"')


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Marker:
    """What a private prefix says of itself."""

    version: str
    """Gazebo's, as ``11.1.0``."""
    triplet: str
    """The folder of libraries, as ``x86_64-linux-gnu``."""
    has_client: bool
    """Whether gzclient can run: Qt and a driver to draw with are there."""
    size: int
    """Bytes on disk."""


def read_marker(prefix: Path) -> Marker | None:
    """Return what the prefix says of itself, or None if it is not a whole one."""
    try:
        content = json.loads((prefix / MARKER).read_bytes())
        if content.pop("format") != _FORMAT:
            return None
        return Marker(**content)
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return None


def write_marker(prefix: Path, marker: Marker) -> None:
    """Declare the prefix whole."""
    text = json.dumps({"format": _FORMAT, **asdict(marker)})
    (prefix / MARKER).write_text(text + "\n", encoding="utf-8")


def header_version(root: Path) -> str | None:
    """Return the version that Gazebo's headers under ``root`` state, if any."""
    try:
        match = _VERSION.search((root / _HEADER).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError):
        return None
    return None if match is None else match.group(1)


def include_folders(root: Path) -> tuple[Path, ...]:
    """Return where the compiler finds Gazebo's headers and those they include.

    Never ``/usr/include`` itself: named once more it would come before the compiler's
    own headers, which then do not find the C library's.
    """
    include = root / "include"
    folders = [include / "gazebo-11"]
    for base in dict.fromkeys((include, Path("/usr/include"))):
        if not folders[1:]:  # both come from one place
            folders += [*base.glob("sdformat-9*"), *base.glob("ignition/*[0-9]")]
    if include != Path("/usr/include"):
        folders.append(include)
    return tuple(folders)


def gazebo_paths(root: Path) -> dict[str, str]:
    """Return where Gazebo finds its own things, as its ``setup.sh`` says it.

    What a person put into these variables comes first.
    """
    share = root / "share" / "gazebo-11"
    plugins = next(
        (
            folder
            for folder in (*root.glob("lib/*/gazebo-11"), root / "lib" / "gazebo-11")
            if folder.is_dir()
        ),
        root / "lib" / "gazebo-11",
    )
    paths = {
        "GAZEBO_RESOURCE_PATH": _after_own("GAZEBO_RESOURCE_PATH", share),
        "GAZEBO_MODEL_PATH": _after_own("GAZEBO_MODEL_PATH", share / "models"),
        "GAZEBO_PLUGIN_PATH": _after_own("GAZEBO_PLUGIN_PATH", plugins / "plugins"),
        # Or the server waits for a web site of models, which may be out of reach.
        "GAZEBO_MODEL_DATABASE_URI": os.environ.get("GAZEBO_MODEL_DATABASE_URI", ""),
    }
    ogre = next(iter(sorted(plugins.parent.glob("OGRE-1.*"))), None)
    return paths if ogre is None else {**paths, "OGRE_RESOURCE_PATH": str(ogre)}


def private_environment(prefix: Path, marker: Marker) -> dict[str, str]:
    """Return the variables that make the programs of a private prefix run."""
    triplet = marker.triplet
    usr = prefix / "usr"
    lib = usr / "lib" / triplet
    libraries = [
        lib,
        usr / "lib",  # libgdal
        lib / "blas",  # links that installing would have made, and unpacking does not
        lib / "lapack",
        lib / "pulseaudio",
        prefix / "lib" / triplet,
        lib / "gazebo-11" / "plugins",
    ]
    own = os.environ.get("LD_LIBRARY_PATH", "").split(":")
    # With a display and no driver to draw with, gzserver would end at once.
    display = {} if marker.has_client else {"DISPLAY": ""}
    return {
        **gazebo_paths(usr),
        "LD_LIBRARY_PATH": ":".join([*map(str, libraries), *filter(None, own)]),
        "SDF_PATH": str(usr / "share" / "sdformat9"),
        "QT_PLUGIN_PATH": str(lib / "qt5" / "plugins"),
        "QT_QPA_PLATFORM_PLUGIN_PATH": str(lib / "qt5" / "plugins" / "platforms"),
        "LIBGL_DRIVERS_PATH": str(lib / "dri"),
        "__EGL_VENDOR_LIBRARY_DIRS": str(usr / "share" / "glvnd" / "egl_vendor.d"),
        "LIBGL_ALWAYS_SOFTWARE": "1",
        "FONTCONFIG_PATH": str(prefix / "etc" / "fonts"),
        "XKB_CONFIG_ROOT": str(usr / "share" / "X11" / "xkb"),
        "PROJ_LIB": str(usr / "share" / "proj"),
        # Nothing sounds; looking for a device takes time and fills the log.
        "ALSOFT_DRIVERS": os.environ.get("ALSOFT_DRIVERS", "null"),
        **display,
    }


def _after_own(variable: str, folder: Path) -> str:
    own = os.environ.get(variable, "").strip(":")
    return f"{own}:{folder}" if own else str(folder)
