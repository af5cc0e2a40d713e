"""Folders of software that tool0 installs, with a lock for each folder."""

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
    """Create a folder, and prevent other processes from changing it.

    Args:
        folder: The folder.  A file named ``lock`` is created in the folder.
        software: Name of the software in the folder, for use in messages.
        error: Type of the exception to raise.

    Raises:
        Tool0Error: If another process is changing the folder, or if files in the folder
            cannot be written.  The type of the exception is ``error``.
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
    """Remove a folder if it exists, and return its size [bytes].

    Args:
        folder: The folder.
        software: Name of the software in the folder, for use in messages.
        error: Type of the exception to raise.

    Raises:
        Tool0Error: If ``exclusive`` raises an error of type ``error``.
    """
    if not folder.is_dir():
        return 0
    with exclusive(folder, software, error):
        size = size_on_disk(folder)
        shutil.rmtree(folder)
    return size


def size_on_disk(root: Path) -> int:
    """Return the size of a folder [bytes].  Hard links are counted once."""
    sizes: dict[int, int] = {}
    for folder, subfolders, files in os.walk(root):
        for name in (*subfolders, *files):
            status = Path(folder, name).lstat()
            sizes[status.st_ino] = status.st_blocks * 512
    return sum(sizes.values())
