"""Finds the files to check below the given paths, and the kind of each file."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import final

from tool0.description.finding import Finding, error_at
from tool0.description.packages import package_name
from tool0.errors import ConfigError, SourceLocation

LARGEST = 5_000_000
"""Size of the largest file that is read [bytes].  Typical descriptions are a hundred
times smaller."""
_NOT_SOURCES = ("build", "devel", "install", "log", "logs", "node_modules")
_IGNORED = ("CATKIN_IGNORE", "COLCON_IGNORE", "AMENT_IGNORE")
_LAUNCHES = "def generate_launch_description("
_ROOT = re.compile(r"<\s*([A-Za-z_][\w.-]*)(?=[\s/>])")


class FileKind(Enum):
    """The kinds of files."""

    URDF = "URDF"
    XACRO = "xacro"
    LAUNCH = "launch file"
    PARAMETERS = "YAML"
    PACKAGE = "package.xml"


@final
@dataclass(frozen=True, slots=True)
class Source:
    """A file to check."""

    path: Path
    kind: FileKind
    was_named: bool
    """Whether the user named the file itself, and not only a folder above it."""


@final
@dataclass(slots=True)
class Sources:
    """All files to check, and the packages that contain them."""

    files: list[Source] = field(default_factory=list)
    packages: dict[str, Path] = field(default_factory=dict)
    """Folder of each package below the named folders, by package name."""
    skipped: list[tuple[Path, str]] = field(default_factory=list)
    """Files that were not read, each with the reason."""

    def of(self, *kinds: FileKind) -> Iterator[Source]:
        return (source for source in self.files if source.kind in kinds)


def collect(paths: Iterable[Path]) -> Sources:
    """Return the sources in ``paths``, which may be files or folders.

    Raises:
        ConfigError: If a path does not exist, or if a named file cannot be read or is
            of an unknown kind.
    """
    sources = Sources()
    seen: set[Path] = set()
    for path in paths:
        if path.is_dir():
            found = [(file, False) for file in _walk(path, sources)]
        else:
            found = [(path, True)]
        for file, was_named in found:
            if file.resolve() not in seen:
                seen.add(file.resolve())
                _add(sources, file, was_named)
    return sources


def _walk(root: Path, sources: Sources) -> Iterator[Path]:
    for name, folders, files in os.walk(root):
        folder = Path(name)
        if any(mark in files for mark in _IGNORED):
            folders.clear()
            continue
        if "package.xml" in files:
            sources.packages.setdefault(package_name(folder), folder)
        folders[:] = sorted(
            name
            for name in folders
            if not name.startswith(".") and name not in _NOT_SOURCES
        )
        yield from (folder / file for file in sorted(files))


def _add(sources: Sources, file: Path, was_named: bool) -> None:
    try:
        if file.stat().st_size > LARGEST:
            kind, why = None, f"is larger than {LARGEST:,} bytes"
        else:
            kind, why = kind_of(file), "is of no kind that is understood"
    except OSError as error:
        kind, why = None, f"cannot be read: {error.strerror}"
    if kind is not None:
        sources.files.append(Source(file, kind, was_named))
    elif was_named:
        raise ConfigError(
            f"'{file}' {why}; tool0 check reads URDF, xacro, launch files, ros_control "
            "YAML, package.xml, and folders of these"
        )
    elif "cannot" in why or "larger" in why:
        sources.skipped.append((file, why))


def read_text(file: Path) -> str:
    """Return the text of a file.

    Raises:
        ConfigError: If the file is not encoded in UTF-8.
    """
    raw = file.read_bytes()
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise ConfigError(
            f"is not UTF-8: {error.reason}; save it as UTF-8",
            SourceLocation(file, line),
        ) from None


def finding_of(error: Exception, rule: str, file: Path) -> Finding:
    """Return an error as a finding, at the error's location or for the whole file."""
    location: SourceLocation = getattr(error, "location", None) or SourceLocation(file)
    return error_at(location, rule, "", getattr(error, "message", str(error)))


def kind_of(file: Path) -> FileKind | None:
    """Return the kind of a file; None if the kind is unknown.

    The kind depends on the name of the file and, for XML, on its outermost element.
    """
    name, suffix = file.name, file.suffix.lower()
    if name == "package.xml":
        return FileKind.PACKAGE
    if suffix in (".yaml", ".yml"):
        return FileKind.PARAMETERS
    if suffix == ".xacro":
        return FileKind.XACRO
    if suffix in (".launch", ".test") or name.endswith(".launch.py"):
        return FileKind.LAUNCH
    if name.endswith("_launch.py"):  # this ending is also common in ROS 2
        text = file.read_text(encoding="utf-8", errors="replace")
        return FileKind.LAUNCH if _LAUNCHES in text else None
    if suffix not in (".xml", ".urdf"):
        return None
    text = file.read_text(encoding="utf-8", errors="replace")
    match = _ROOT.search(_without_comments(text))
    root = match[1] if match else ""
    if root == "launch":
        return FileKind.LAUNCH
    if root == "robot" or suffix == ".urdf":
        return FileKind.XACRO if "xmlns:xacro" in text else FileKind.URDF
    return None


def _without_comments(xml: str) -> str:
    before, *rest = xml.split("<!--")
    return before + "".join(part.partition("-->")[2] for part in rest)
