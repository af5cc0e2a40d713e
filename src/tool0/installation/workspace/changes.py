"""What to do with each file of a package, by what is there and what was written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path, PurePosixPath
from typing import final

from tool0.errors import ConfigError
from tool0.installation.workspace.record import Record, digest


class Action(Enum):
    """What happens to one file."""

    ADD = "new"
    UPDATE = "updated"
    REMOVE = "removed"
    REPLACE = "overwritten"
    """A person's edits go; they are kept beside it."""
    KEEP = "kept"
    """A person's edits stay."""
    LEAVE = "unchanged"


@final
@dataclass(frozen=True, slots=True)
class Change:
    """What happens to one file."""

    path: Path
    action: Action
    data: bytes | None = None
    """What it holds afterwards; None if it is gone or stays as it is."""


def changes(
    package: Path,
    wanted: Mapping[PurePosixPath, bytes],
    record: Record,
    *,
    force: bool,
) -> tuple[Change, ...]:
    """Return the change of each file that is wanted now or was written before.

    Args:
        package: The package's folder.
        wanted: What the files are to hold, by their paths below it.
        record: What was written before.
        force: Whether edited files are overwritten, too.
    """
    paths = sorted({*wanted, *record})
    return tuple(
        _change(package / path, wanted.get(path), record.get(path, frozenset()), force)
        for path in paths
    )


def _change(
    path: Path, wanted: bytes | None, written: frozenset[str], force: bool
) -> Change:
    present = _read(path)
    if present == wanted:
        return Change(path, Action.LEAVE)
    if present is None:
        return Change(path, Action.ADD, wanted)
    if path.is_symlink() or digest(present) not in written:
        # what we ship no longer and a person has edited is theirs, force or not
        if force and wanted is not None:
            return Change(path, Action.REPLACE, wanted)
        return Change(path, Action.KEEP)
    if wanted is None:
        return Change(path, Action.REMOVE)
    return Change(path, Action.UPDATE, wanted)


def _read(path: Path) -> bytes | None:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        if path.is_symlink():
            raise ConfigError(f"'{path}' is a link to nothing; remove it") from None
        return None
    except OSError as error:
        why = error.strerror or str(error)
        raise ConfigError(f"cannot read '{path}': {why}; move it away") from None
