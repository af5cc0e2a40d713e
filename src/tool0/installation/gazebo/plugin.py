"""Compiles the C++ plugin for Gazebo on this machine with Gazebo's headers.

tool0 does not contain a compiled plugin, because Gazebo's classes differ between
versions, and the compiler's library differs between distributions.
"""

from __future__ import annotations

import hashlib
import logging
import os
import platform
import re
import shlex
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

from tool0.errors import EngineUnavailableError
from tool0.installation.child_process import last_lines, run_program
from tool0.installation.gazebo.installation import GazeboInstallation
from tool0.user_data import cache_folder

logger = logging.getLogger(__name__)

_BRIDGE: Final = Path(__file__).parent / "bridge"
_SOURCES: Final = (_BRIDGE / "bridge.cc", _BRIDGE / "preload.cc")
"""Each file is compiled alone; the headers beside the file are included from it."""
_INCLUDE: Final = re.compile(r'^#include "(.+)"', re.MULTILINE)
_FLAGS: Final = ("-O2", "-fPIC", "-shared", "-std=c++17", "-pthread")


@final
@dataclass(frozen=True, slots=True)
class BridgeLibraries:
    """Paths of the libraries that gzserver loads."""

    bridge: Path
    """Path of the plugin that communicates with the engine."""
    preload: Path
    """Path of the library that is preloaded into gzserver and gzclient.  The library
    restricts both programs to this machine."""


def plugin_folder() -> Path:
    """Return the folder of compiled libraries.  The folder may not exist."""
    return cache_folder() / "gazebo"


def bridge_libraries(installation: GazeboInstallation) -> BridgeLibraries:
    """Return the libraries for this Gazebo, after compiling them if necessary.

    Raises:
        EngineUnavailableError: If the compilation fails.
    """
    paths = expected_libraries(installation)
    for source, library in zip(_SOURCES, (paths.bridge, paths.preload), strict=True):
        if not library.is_file():
            _compile(source, installation, library)
    return paths


def expected_libraries(installation: GazeboInstallation) -> BridgeLibraries:
    """Return the paths of this Gazebo's libraries, which may not be compiled yet.

    Each name contains a hash of everything on which the library depends, except the
    compiler's version.  A compiled library therefore remains in use after the compiler
    is removed.
    """

    def library(source: Path) -> Path:
        dependencies = (
            *(file.read_text(encoding="utf-8") for file in _files(source)),
            *_FLAGS,
            installation.version,
            *map(str, installation.include_dirs),
            platform.machine(),
            # a library that was compiled for a newer libc cannot be loaded
            *platform.libc_ver(),
        )
        digest = hashlib.sha256("\0".join(dependencies).encode()).hexdigest()[:16]
        return plugin_folder() / f"{source.stem}-{digest}.so"

    return BridgeLibraries(*map(library, _SOURCES))


def compiler() -> list[str] | None:
    """Return the command of the C++ compiler; None if there is no compiler."""
    command = shlex.split(os.environ.get("CXX", "")) or ["g++"]
    return command if shutil.which(command[0]) else None


def require_compiler() -> list[str]:
    """Return the command of the C++ compiler, or raise EngineUnavailableError."""
    command = compiler()
    if command is None:
        raise EngineUnavailableError(
            "the plugin for Gazebo must be compiled, and there is no C++ compiler "
            "here; install one (apt install g++), or set CXX to it"
        )
    return command


def _files(source: Path) -> list[Path]:
    """Return a source and all headers that it includes from its folder, sorted."""
    found, unread = {source}, [source]
    while unread:
        text = unread.pop().read_text(encoding="utf-8")
        headers = {source.parent / name for name in _INCLUDE.findall(text)}
        unread.extend(headers - found)
        found |= headers
    return sorted(found)


def _compile(source: Path, installation: GazeboInstallation, library: Path) -> None:
    command = require_compiler()
    logger.info("compiling %s for Gazebo %s", source.name, installation.version)
    try:
        library.parent.mkdir(parents=True, exist_ok=True)
        # Two processes may compile at the same time.  The last result is kept.
        with tempfile.TemporaryDirectory(dir=library.parent, prefix=".new-") as folder:
            made = Path(folder) / library.name
            includes = [f"-isystem{path}" for path in installation.include_dirs]
            output = ["-o", str(made)]
            answer = run_program([*command, *_FLAGS, *includes, str(source), *output])
            if answer.returncode != 0:
                raise EngineUnavailableError(
                    f"cannot compile {source.name} against the headers of Gazebo "
                    f"{installation.version}; {command[0]} said:\n"
                    f"{last_lines(answer.stderr, 12)}"
                )
            made.replace(library)
    except OSError as error:
        raise EngineUnavailableError(
            f"cannot write '{error.filename or library}': {error.strerror}"
        ) from None
