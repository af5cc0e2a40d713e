"""The user's files: their folders, locks on them, and checks for write access."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tool0.errors import ConfigError


def data_folder() -> Path:
    """Return tool0's folder in the user's data home; the folder may not exist yet."""
    return _home("XDG_DATA_HOME", ".local/share") / "tool0"


def cache_folder() -> Path:
    """Return tool0's cache folder, which may not exist yet."""
    return _home("XDG_CACHE_HOME", ".cache") / "tool0"


def _home(variable: str, default: str) -> Path:
    """Return a base directory of the XDG specification; relative paths are ignored."""
    folder = Path(os.environ.get(variable, ""))
    return folder if folder.is_absolute() else expanded(Path("~", default))


def expanded(path: str | Path) -> Path:
    """Return ``path`` with ``~`` replaced by the home folder.

    Raises:
        ConfigError: If the home folder is unknown.
    """
    try:
        return Path(path).expanduser()
    except RuntimeError:
        raise ConfigError(
            f"{path}: the home folder is not known; set the environment variable HOME, "
            "or write the whole path"
        ) from None


@contextmanager
def locked(file: Path, *, wait: bool = True) -> Iterator[None]:
    """Hold the lock ``file``, which excludes other processes and threads.

    Args:
        file: The lock file, which is created if it does not exist.  The file's content
            is ignored.
        wait: Whether to wait while another process or thread holds the lock.

    Raises:
        BlockingIOError: If the lock is already held and ``wait`` is false.
    """
    with file.open("a") as handle:
        if sys.platform == "win32":
            import msvcrt

            mode = msvcrt.LK_LOCK if wait else msvcrt.LK_NBLCK
            msvcrt.locking(handle.fileno(), mode, 1)
        else:
            import fcntl

            fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        yield


def replace_text(file: Path, text: str) -> None:
    """Write a file atomically, so that no process reads an incomplete file.

    Raises:
        OSError: If the file cannot be written; the old file is then unchanged.
    """
    descriptor, name = tempfile.mkstemp(dir=file.parent, prefix=".new-")
    new = Path(name)
    try:
        with os.fdopen(descriptor, "wb") as handle:
            handle.write(text.encode())
            handle.flush()
            os.fsync(handle.fileno())
        new.replace(file)
    except BaseException:
        new.unlink(missing_ok=True)
        raise


def require_writable(path: Path) -> None:
    """Raise ConfigError if a file cannot be written; do not change its content."""
    is_new = not path.exists()
    try:
        with path.open("ab"):
            pass
        if is_new:
            path.unlink()
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error.strerror}") from error
