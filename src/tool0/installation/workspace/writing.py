"""Writing the packages: each file whole or not at all, a person's edits left alone."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import final

from tool0.errors import ConfigError
from tool0.installation.workspace.changes import Action, Change, changes
from tool0.installation.workspace.contents import PACKAGES, SCRIPTS, contents
from tool0.installation.workspace.places import source_folder
from tool0.installation.workspace.record import (
    NAME,
    Record,
    digest,
    read_record,
    record_text,
)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Written:
    """What became of a workspace's files."""

    source: Path
    """The folder that the packages are in."""
    changes: tuple[Change, ...]
    backups: Mapping[Path, Path]
    """File that was overwritten → where its edits are now."""

    def paths(self, action: Action) -> tuple[Path, ...]:
        """Return the files that this happened to."""
        return tuple(item.path for item in self.changes if item.action is action)


def write_workspace(
    folder: Path, *, upstream_meshes: bool = False, force: bool = False
) -> Written:
    """Write the packages into the workspace ``folder``.

    Nothing is written before it is known what is to happen to every file.

    Raises:
        ConfigError: If that cannot be; what is written by then is whole, and the same
            call goes on where this one stopped.
    """
    source = source_folder(folder)
    files = contents(upstream_meshes=upstream_meshes)
    plans = []
    for name in PACKAGES:
        wanted = {
            path.relative_to(name): data
            for path, data in files.items()
            if path.parts[0] == name
        }
        record = read_record(source / name)
        plan = changes(source / name, wanted, record, force=force)
        plans.append((source / name, wanted, record, plan))
    backups: dict[Path, Path] = {}
    for package, wanted, record, plan in plans:
        backups |= _carry_out(package, wanted, record, plan)
    done = tuple(change for *_, plan in plans for change in plan)
    return Written(source=source, changes=done, backups=backups)


def _carry_out(
    package: Path,
    wanted: Mapping[PurePosixPath, bytes],
    record: Record,
    plan: tuple[Change, ...],
) -> dict[Path, Path]:
    """Change the files of one package; return where edits were put."""
    after: dict[PurePosixPath, frozenset[str]] = {
        path: frozenset({digest(data)}) for path, data in wanted.items()
    }
    for change in plan:  # edited, and shipped no longer: theirs from now on
        path = PurePosixPath(change.path.relative_to(package).as_posix())
        if change.action is Action.KEEP and path in wanted:
            after[path] |= record.get(path, frozenset())
    meanwhile = {
        path: after.get(path, frozenset()) | record.get(path, frozenset())
        for path in {*after, *record}
    }
    backups = {}
    _write(package / NAME, record_text(meanwhile).encode())
    for change in plan:
        if change.action is Action.REPLACE:
            backups[change.path] = _put_aside(change.path)
        if change.action is Action.REMOVE:
            _remove(change.path)
        elif change.data is not None:
            _write(change.path, change.data)
    _write(package / NAME, record_text(after).encode())
    return backups


def _write(path: Path, data: bytes) -> None:
    """Make ``path`` hold ``data``, at once or not at all."""
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
        raise _refusal("write", path, error) from None


def _put_aside(path: Path) -> Path:
    """Rename an edited file to a name that is free, and return that."""
    number, aside = 1, path.with_name(f"{path.name}.orig")
    while aside.exists() or aside.is_symlink():
        number += 1
        aside = path.with_name(f"{path.name}.orig{number}")
    try:
        path.rename(aside)
    except OSError as error:
        raise _refusal("rename", path, error) from None
    return aside


def _remove(path: Path) -> None:
    try:
        path.unlink()
    except OSError as error:
        raise _refusal("remove", path, error) from None


def _refusal(verb: str, path: Path, error: OSError) -> ConfigError:
    why = error.strerror or str(error)
    return ConfigError(
        f"cannot {verb} '{path}': {why}; when that is mended, run the same again, "
        "which goes on from here"
    )
