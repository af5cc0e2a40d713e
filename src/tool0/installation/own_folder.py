"""Folders of software that tool0 installs: only one process at a time changes them."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tool0.errors import Tool0Error
from tool0.user_data import locked


@contextmanager
def exclusive(folder: Path, software: str, error: type[Tool0Error]) -> Iterator[None]:
    """Make a folder, and keep other processes from changing it.

    Args:
        folder: The folder; a file ``lock`` is made in it.
        software: The name of what is installed there, for messages.
        error: The type of the exception.

    Raises:
        Tool0Error: Of the type ``error``, if another process changes the folder, or
            something in it cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with locked(folder / "lock", wait=False):
            yield
    except BlockingIOError:
        raise error(
            f"another process installs or removes {software} in '{folder}'; wait for it"
        ) from None
    except OSError as failure:
        raise error(
            f"cannot write '{failure.filename or folder}': {failure.strerror}"
        ) from None


def removed(folder: Path, software: str, error: type[Tool0Error]) -> int:
    """Remove a folder, if there is one, and return its size [bytes].

    Args:
        folder: The folder.
        software: The name of what is installed there, for messages.
        error: The type of the exception.

    Raises:
        Tool0Error: As ``exclusive`` does.
    """
    if not folder.is_dir():
        return 0
    with exclusive(folder, software, error):
        size = size_on_disk(folder)
        shutil.rmtree(folder)
    return size


def size_on_disk(root: Path) -> int:
    """Return the size of a folder [bytes]; hard links count once."""
    sizes: dict[int, int] = {}
    for folder, subfolders, files in os.walk(root):
        for name in (*subfolders, *files):
            status = Path(folder, name).lstat()
            sizes[status.st_ino] = status.st_blocks * 512
    return sum(sizes.values())
