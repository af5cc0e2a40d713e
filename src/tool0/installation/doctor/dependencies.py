"""The Python packages that tool0 needs, and which of them are not there."""

from __future__ import annotations

import importlib.metadata
import re
import shlex
import sys

from tool0.installation.doctor.line import Line


def lacking() -> list[str]:
    """Return the requirements that are not installed, as ``mujoco>=3.3``."""
    return [text for text in _requirements() if version(name_of(text)) is None]


def without(what: str, error: ImportError) -> Line:
    """Return what is told of something that cannot be imported."""
    package = (error.name or what).partition(".")[0]
    wanted = next((t for t in _requirements() if name_of(t) == package), package)
    again = [] if version(package) is None else ["--force-reinstall"]
    return Line(
        what=what, state="missing", found=str(error), remedy=install(*again, wanted)
    )


def install(*words: str) -> str:
    """Return the command that installs packages for the Python that runs this."""
    return shlex.join([sys.executable, "-m", "pip", "install", *words])


def version(package: str) -> str | None:
    """Return the version that is installed, None if none is."""
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def name_of(requirement: str) -> str:
    """Return the package that a requirement is of."""
    return re.split(r"[^\w.-]", requirement, maxsplit=1)[0]


def _requirements() -> list[str]:
    try:
        stated = importlib.metadata.requires("tool0") or []
    except importlib.metadata.PackageNotFoundError:  # run from a folder of sources
        return []
    return [text for text in stated if ";" not in text]
