"""Writes the packages, and keeps what a person has edited.

Each file is written whole or not at all.  A hidden file in each package holds the
hashes of what was written.  By them a later run distinguishes its own files from edited
ones.  An interrupted run leaves both the old and the new hash, so that either counts.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path, PurePosixPath
from typing import Final, final

from tool0.errors import ConfigError
from tool0.installation.workspace.layout import (
    PACKAGES,
    SCRIPTS,
    package_files,
    source_folder,
)

RECORD_FILE: Final = ".tool0-workspace.json"
"""The hidden file."""
_ABOUT: Final = (
    "Written by `tool0 workspace`: by these hashes it knows the files that it wrote "
    "from those that were edited."
)
_Hashes = Mapping[PurePosixPath, frozenset[str]]
"""File, below its package, → SHA-256 of what we may have written there."""


class FileAction(Enum):
    """What happens to one file."""

    ADD = "new"
    UPDATE = "updated"
    REMOVE = "removed"
    REPLACE = "overwritten"
    """The edited file is renamed."""
    KEEP = "kept"
    """The file was edited, and stays."""
    LEAVE = "unchanged"


@final
@dataclass(frozen=True, slots=True)
class FileChange:
    """What happens to one file."""

    path: Path
    action: FileAction
    data: bytes | None = None
    """Its new content; None if it is removed or stays as it is."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class WorkspaceChanges:
    """What was done to a workspace."""

    source: Path
    """The folder that the packages are in."""
    changes: tuple[FileChange, ...]
    backups: Mapping[Path, Path]
    """Overwritten file → its edited version."""

    def paths(self, action: FileAction) -> tuple[Path, ...]:
        """Return the files that this happened to."""
        return tuple(item.path for item in self.changes if item.action is action)


def write_workspace(
    folder: Path, *, upstream_meshes: bool = False, force: bool = False
) -> WorkspaceChanges:
    """Write the packages into the workspace ``folder``.

    Nothing is written before the change of every file is known.

    Args:
        folder: The workspace; made if it does not exist.
        upstream_meshes: Whether the robot looks as in upstream's packages by default.
        force: Whether edited files are overwritten, too.

    Raises:
        ConfigError: If a file cannot be read or written.  Files written by then are
            complete, and the same call resumes.
    """
    source = source_folder(folder)
    files = package_files(upstream_meshes=upstream_meshes)
    plans = []
    for name in PACKAGES:
        wanted = {
            path.relative_to(name): data
            for path, data in files.items()
            if path.parts[0] == name
        }
        written = _read_record(source / name)
        changes = tuple(
            _change(
                source / name / path,
                wanted.get(path),
                written.get(path, frozenset()),
                force,
            )
            for path in sorted({*wanted, *written})
        )
        plans.append((source / name, wanted, written, changes))
    backups: dict[Path, Path] = {}
    for plan in plans:
        backups |= _write_package(*plan)
    done = tuple(change for *_, changes in plans for change in changes)
    return WorkspaceChanges(source=source, changes=done, backups=backups)


def _change(
    path: Path, wanted: bytes | None, written: frozenset[str], force: bool
) -> FileChange:
    """Return what happens to a file.

    Args:
        path: The file.
        wanted: Its new content; None if it is no longer part of the package.
        written: The hashes of what we may have written there.
        force: Whether it is overwritten even if it was edited.
    """
    present = _read(path)
    if present == wanted:
        return FileChange(path, FileAction.LEAVE)
    if present is None:
        return FileChange(path, FileAction.ADD, wanted)
    if path.is_symlink() or _digest(present) not in written:
        # an edited file that we no longer ship is the person's, with force, too
        if force and wanted is not None:
            return FileChange(path, FileAction.REPLACE, wanted)
        return FileChange(path, FileAction.KEEP)
    if wanted is None:
        return FileChange(path, FileAction.REMOVE)
    return FileChange(path, FileAction.UPDATE, wanted)


def _write_package(
    package: Path,
    wanted: Mapping[PurePosixPath, bytes],
    written: _Hashes,
    changes: tuple[FileChange, ...],
) -> dict[Path, Path]:
    """Change the files of one package; return where edited ones were put."""
    after: dict[PurePosixPath, frozenset[str]] = {
        path: frozenset({_digest(data)}) for path, data in wanted.items()
    }
    for change in changes:  # an edited file that we no longer ship is forgotten
        path = PurePosixPath(change.path.relative_to(package).as_posix())
        if change.action is FileAction.KEEP and path in wanted:
            after[path] |= written.get(path, frozenset())
    meanwhile = {
        path: after.get(path, frozenset()) | written.get(path, frozenset())
        for path in {*after, *written}
    }
    backups = {}
    _write(package / RECORD_FILE, _record_text(meanwhile))
    for change in changes:
        if change.action is FileAction.REPLACE:
            backups[change.path] = _back_up(change.path)
        if change.action is FileAction.REMOVE:
            _remove(change.path)
        elif change.data is not None:
            _write(change.path, change.data)
    _write(package / RECORD_FILE, _record_text(after))
    return backups


# --- the record of what was written ---


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _read_record(package: Path) -> _Hashes:
    """Return the hashes of a package; empty if there is no record that can be read.

    Then every file that is not as we would write it counts as edited.
    """
    try:
        text = (package / RECORD_FILE).read_text(encoding="utf-8")
        return {
            PurePosixPath(name): frozenset(map(str, hashes))
            for name, hashes in json.loads(text)["sha256"].items()
        }
    except (FileNotFoundError, NotADirectoryError):
        return {}
    except (ValueError, KeyError, AttributeError, TypeError):  # not one of ours
        return {}


def _record_text(record: _Hashes) -> bytes:
    files = {str(path): sorted(record[path]) for path in sorted(record)}
    return f"{json.dumps({'about': _ABOUT, 'sha256': files}, indent=1)}\n".encode()


# --- files ---


def _read(path: Path) -> bytes | None:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        if path.is_symlink():
            raise ConfigError(f"'{path}' is a dangling link; remove it") from None
        return None
    except OSError as error:
        reason = error.strerror or str(error)
        raise ConfigError(f"cannot read '{path}': {reason}; move it away") from None


def _write(path: Path, data: bytes) -> None:
    """Replace the content of ``path`` atomically."""
    new = path.with_name(f".{path.name}.{os.getpid()}.new")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            new.write_bytes(data)
            if path.parent.name == SCRIPTS:
                mode = new.stat().st_mode
                new.chmod(mode | (mode & 0o444) >> 2)  # who may read it may run it
            new.replace(path)
        finally:
            new.unlink(missing_ok=True)
    except OSError as error:
        raise _failure("write", path, error) from None


def _back_up(path: Path) -> Path:
    """Rename an edited file to a free name, and return that."""
    number, backup = 1, path.with_name(f"{path.name}.orig")
    while backup.exists() or backup.is_symlink():
        number += 1
        backup = path.with_name(f"{path.name}.orig{number}")
    try:
        path.rename(backup)
    except OSError as error:
        raise _failure("rename", path, error) from None
    return backup


def _remove(path: Path) -> None:
    try:
        path.unlink()
    except OSError as error:
        raise _failure("remove", path, error) from None


def _failure(verb: str, path: Path, error: OSError) -> ConfigError:
    reason = error.strerror or str(error)
    return ConfigError(
        f"cannot {verb} '{path}': {reason}; correct that, then run the same command "
        "again, which resumes"
    )
