"""The programs of a package in the workspace, found in the package's build files."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Final

from tool0.errors import SourceLocation, is_typo, nearest_name
from tool0.lint.launch.load_context import is_file
from tool0.lint.launch.python.substitution import Resolver

_LARGEST: Final = 1_000_000
_BUILD_FILES: Final = ("CMakeLists.txt", "setup.py", "setup.cfg", "pyproject.toml")
_WORD: Final = re.compile(r"[\w.-]+")
_MAX_FILES: Final = 2000


def check_executable(
    package: str, folder: Path, program: str, where: SourceLocation, resolver: Resolver
) -> None:
    """Report an error if a package does not contain the given program."""
    if _is_installed(folder):
        return
    words = _words(folder)
    if program in words or not words:
        return
    near = nearest_name(program, words, cutoff=0.75)
    resolver.report(
        where,
        "missing-executable",
        program,
        f"is no program that the build files of {package} name, so launch does not "
        "find it",
        f"did you mean '{near}'?" if near else f"install it in {package}",
        severity="error" if is_typo(program, near) else "warning",
    )


def _is_installed(folder: Path) -> bool:
    """Return whether a folder is an installed share folder without sources."""
    return not any(is_file(folder / name) for name in _BUILD_FILES)


@cache
def _words(folder: Path) -> frozenset[str]:
    """Return all words in a package's build files, and the names of all its files.

    File names are included because CMake may find programs with a glob pattern.
    """
    words: set[str] = set()
    for name in _BUILD_FILES:
        file = folder / name
        if is_file(file) and file.stat().st_size <= _LARGEST:
            text = file.read_text(encoding="utf-8", errors="replace")
            words.update(_WORD.findall(text))
    files = (path for path in folder.rglob("*") if path.is_file())
    for _, path in zip(range(_MAX_FILES), files):  # noqa: B905  # stops at the shorter
        words.add(path.name)
    return frozenset(words)
