"""Writes ROS packages into a catkin workspace, and updates these packages.

Each file is written completely or not at all, and edited files are kept.  A hidden file
in each package contains the hashes of the written files.  A later run uses the hashes
to detect edits.  After an interrupted run, the hidden file contains both the old and
the new hash of a file, and either hash is accepted.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum
from itertools import chain, count
from pathlib import Path, PurePosixPath
from typing import Final, final

from tool0.description.packages import crawl, package_name
from tool0.errors import ConfigError
from tool0.user_data import expanded

RECORD_FILE: Final = ".tool0-workspace.json"
"""Name of the hidden file with the hashes."""
_ABOUT: Final = (
    "Written by `tool0 workspace`: with these hashes it distinguishes the files that "
    "it wrote from edited ones."
)
_PROGRAMS: Final = "scripts"
"""Name of the folder of executable files."""
_Files = Mapping[PurePosixPath, bytes]
_Hashes = dict[PurePosixPath, frozenset[str]]
"""SHA-256 hashes of the versions of a file that tool0 has written, by the file's path
in its package."""


class FileAction(Enum):
    """Action that was taken for one file."""

    ADD = "new"
    UPDATE = "updated"
    REMOVE = "removed"
    REPLACE = "overwritten"
    """The file was edited.  The edited version is renamed, and the new version is
    written."""
    KEEP = "kept"
    """The file was edited, and it is kept."""
    LEAVE = "unchanged"


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class WorkspaceChanges:
    """The changes that were made in a workspace."""

    source: Path
    """The folder that contains the packages."""
    packages: tuple[str, ...]
    """Names of the packages."""
    actions: Mapping[Path, FileAction]
    """Action that was taken for each file, by path."""
    backups: Mapping[Path, Path]
    """Backup of the edited version of each overwritten file, by path."""

    def paths(self, action: FileAction) -> tuple[Path, ...]:
        """Return the files for which ``action`` was taken."""
        return tuple(path for path, what in self.actions.items() if what is action)


def write_workspace(
    folder: Path, files: _Files, *, force: bool = False
) -> WorkspaceChanges:
    """Write packages into the workspace ``folder``.

    Nothing is written until the change to every file is known.

    Args:
        folder: The workspace.  The folder is created if it does not exist.
        files: Contents by path.  Each path starts with the package's name.
        force: Whether to overwrite edited files.

    Raises:
        ConfigError: If a file cannot be read or written.  Files that have already been
            written are complete, and the next call writes the remaining files.
    """
    packages = sorted({path.parts[0] for path in files})
    source = source_folder(folder, packages)
    actions: dict[Path, FileAction] = {}
    plans = []
    for package in (source / name for name in packages):
        wanted = {
            path.relative_to(package.name): data
            for path, data in files.items()
            if path.parts[0] == package.name
        }
        written = _read_record(package)
        for path in sorted({*wanted, *written}):
            hashes = written.get(path, frozenset())
            file = package / path
            actions[file] = _action(file, wanted.get(path), hashes, force)
        plans.append((package, wanted, written))
    backups: dict[Path, Path] = {}
    for package, wanted, written in plans:
        _write_package(package, wanted, written, actions, backups)
    return WorkspaceChanges(
        source=source, packages=tuple(packages), actions=actions, backups=backups
    )


def _action(
    path: Path, wanted: bytes | None, written: frozenset[str], force: bool
) -> FileAction:
    """Return the action that is necessary for a file.

    ``wanted`` is the new content, or None if the file is no longer part of the package.
    ``written`` contains the hashes of the versions that tool0 may have written.
    """
    present = _read(path)
    if present == wanted:
        return FileAction.LEAVE
    if present is None:
        return FileAction.ADD
    if path.is_symlink() or _digest(present) not in written:
        # an edited file that tool0 no longer contains is kept, even with force
        is_replaced = force and wanted is not None
        return FileAction.REPLACE if is_replaced else FileAction.KEEP
    return FileAction.REMOVE if wanted is None else FileAction.UPDATE


def _write_package(
    package: Path,
    wanted: _Files,
    written: _Hashes,
    actions: Mapping[Path, FileAction],
    backups: dict[Path, Path],
) -> None:
    """Change the files of one package.

    Add the backups of edited files to ``backups``.
    """
    after = {path: frozenset({_digest(data)}) for path, data in wanted.items()}
    # an edited file that tool0 no longer contains is removed from the record
    for path in after:
        if actions[package / path] is FileAction.KEEP:
            after[path] |= written.get(path, frozenset())
    meanwhile = {
        path: after.get(path, frozenset()) | written.get(path, frozenset())
        for path in {*after, *written}
    }
    _write(package / RECORD_FILE, _record_text(meanwhile))
    for path in sorted({*wanted, *written}):
        file = package / path
        action = actions[file]
        if action is FileAction.REPLACE:
            backups[file] = _back_up(file)
        if action is FileAction.REMOVE:
            with _named_failure("remove", file):
                file.unlink()
        elif action not in (FileAction.KEEP, FileAction.LEAVE):
            _write(file, wanted[path])
    _write(package / RECORD_FILE, _record_text(after))


# --- files and their hashes ---


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _read_record(package: Path) -> _Hashes:
    """Return the recorded hashes of a package; empty if there is no record.

    Without a readable record, every file that differs from the new content is treated
    as edited.
    """
    try:
        text = (package / RECORD_FILE).read_text(encoding="utf-8")
        return {
            PurePosixPath(name): frozenset(map(str, hashes))
            for name, hashes in json.loads(text)["sha256"].items()
        }
    except (FileNotFoundError, NotADirectoryError):
        return {}
    except (ValueError, KeyError, AttributeError, TypeError):  # the record was edited
        return {}


def _record_text(record: _Hashes) -> bytes:
    files = {str(path): sorted(record[path]) for path in sorted(record)}
    return f"{json.dumps({'about': _ABOUT, 'sha256': files}, indent=1)}\n".encode()


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
    with _named_failure("write", path):
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            new.write_bytes(data)
            if path.parent.name == _PROGRAMS:
                mode = new.stat().st_mode
                # every user who may read the file may run it
                new.chmod(mode | (mode & 0o444) >> 2)
            new.replace(path)
        finally:
            new.unlink(missing_ok=True)


def _back_up(path: Path) -> Path:
    """Rename an edited file to an unused name, and return its new path."""
    numbers = chain([""], count(2))
    paths = (path.with_name(f"{path.name}.orig{number}") for number in numbers)
    backup = next(p for p in paths if not (p.exists() or p.is_symlink()))
    with _named_failure("rename", path):
        path.rename(backup)
    return backup


@contextmanager
def _named_failure(verb: str, path: Path) -> Iterator[None]:
    """Raise ConfigError in place of an OSError."""
    try:
        yield
    except OSError as error:
        raise ConfigError(
            f"cannot {verb} '{path}': {error.strerror or error}; correct that, then "
            "run the same command again, which resumes"
        ) from None


# --- the folder ---


def source_folder(folder: Path, packages: Collection[str] = ()) -> Path:
    """Return the folder for ``packages`` in the workspace ``folder``.

    The result is ``src`` if ``folder`` is a workspace, empty or new.  The result is
    ``folder`` itself if ``folder`` is named ``src``, contains packages, or was
    initialized by catkin_init_workspace.

    Raises:
        ConfigError: If packages cannot be written to the folder.
    """
    folder = expanded(folder).absolute()
    _refuse_files(folder)
    for path in (folder, *folder.parents):
        if (path / "package.xml").is_file():
            raise ConfigError(
                f"'{path}' is a ROS package, and packages cannot contain others; "
                "pass the workspace, the folder above its 'src'"
            )
    below = folder / "src"
    found = below if below.is_dir() or not _holds_packages(folder) else folder
    _refuse_files(found)
    _refuse_duplicates(found, packages)
    return found


def _holds_packages(folder: Path) -> bool:
    if folder.name == "src":
        return True
    # catkin's top-level CMakeLists.txt is a link to a file in catkin's folder
    has_toplevel = (folder / "CMakeLists.txt").is_symlink()
    return has_toplevel or any(folder.glob("*/package.xml"))


def _refuse_files(folder: Path) -> None:
    for path in (folder, *folder.parents):
        if path.exists() and not path.is_dir():
            raise ConfigError(f"'{path}' is not a folder; pass a catkin workspace")
        if path.is_symlink() and not path.exists():
            raise ConfigError(f"'{path}' is a dangling link; remove or correct it")


def _refuse_duplicates(source: Path, packages: Collection[str]) -> None:
    """Raise ConfigError if one of the packages already exists in another folder."""
    ours = {source / name for name in packages}
    for path in ours:
        if path.is_symlink():
            raise ConfigError(
                f"'{path}' is a link to '{path.resolve()}', which it would change; "
                "remove it, or pass another workspace"
            )
    for path in crawl(source):
        name = package_name(path)
        if name in packages and path not in ours:
            raise ConfigError(
                f"'{path}' is already a package called {name}, and catkin accepts only "
                "one with that name; remove it, or put a CATKIN_IGNORE file into it"
            )
