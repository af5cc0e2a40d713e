"""The address of a running bring-up: one socket file per name."""

from __future__ import annotations

import os
import re
import socket
import stat
import struct
from pathlib import Path
from typing import IO, final

from tool0.errors import TransportError

DEFAULT_NAME = "tool0"
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")
_MAX_PATH = 103
"""Longest socket path [bytes].  The limit of sockaddr_un is 107 bytes on Linux and 103
bytes on macOS (unix(7))."""


def check_supported() -> None:
    """Raise TransportError if the platform has no Unix sockets."""
    if not hasattr(socket, "AF_UNIX"):
        raise TransportError(
            "remote access needs Unix sockets, which Python lacks on this platform; "
            "run `tool0 bringup --no-remote`, or use the Python API in one process"
        )


def folders() -> tuple[Path, ...]:
    """Return the folders that may contain sockets, with the preferred folder first.

    ``XDG_RUNTIME_DIR`` is private to the user and is emptied at logout.  If this
    variable is not set (for example, in a container or under cron), a folder with mode
    0700 is used instead.
    """
    import tempfile

    runtime = os.environ.get("XDG_RUNTIME_DIR", "")
    fallback = Path(tempfile.gettempdir()) / f"tool0-{os.getuid()}"
    if runtime and Path(runtime).is_absolute():
        return (Path(runtime) / "tool0", fallback)
    return (fallback,)


def socket_path(folder: Path, name: str) -> Path:
    """Return the socket file of ``name``; raise TransportError for an invalid name."""
    if not _NAME.fullmatch(name):
        raise TransportError(
            f"a bringup cannot be named '{name}': use up to 64 letters, digits, "
            "'_', '-' and '.', a letter or digit first"
        )
    path = folder / f"{name}.sock"
    if len(os.fsencode(path)) > _MAX_PATH:
        raise TransportError(
            f"the socket path {path} is longer than {_MAX_PATH} bytes; "
            "use a shorter --name, or set XDG_RUNTIME_DIR to a shorter folder"
        )
    return path


def running_names() -> tuple[str, ...]:
    """Return the names for which a socket file exists.

    For some names, the process may have ended without removing its socket file.
    """
    found = {
        path.stem
        for folder in folders()
        if folder.exists() and insecurity(folder) is None
        for path in folder.glob("*.sock")
    }
    return tuple(sorted(found))


def insecurity(folder: Path) -> str | None:
    """Return why other users could create a socket in ``folder``; None if they cannot.

    Raises:
        OSError: If the folder does not exist.
    """
    status = folder.lstat()
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != os.getuid():
        return f"{folder} is not a folder of this user; remove it"
    if status.st_mode & 0o077:
        return f"{folder} is open to other users; run: chmod 700 {folder}"
    return None


def is_foreign(peer: socket.socket) -> bool:
    """Return whether the other process is known to belong to another user."""
    if not hasattr(socket, "SO_PEERCRED"):
        return False
    credentials = struct.Struct("3i")
    data = peer.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, credentials.size)
    _, user, _ = credentials.unpack(data)
    return bool(user != os.getuid())


@final
class Claim:
    """Exclusive claim of this process to the name of a bring-up, until ``close``.

    The kernel releases the lock when the process ends.  Therefore, the files of an
    ended process never block the name, and a running process never loses the name.
    """

    def __init__(self, name: str) -> None:
        """Acquire the name.

        Raises:
            TransportError: If another process holds the name, or if there is no private
                folder.
        """
        check_supported()
        self.name = name
        self.path = socket_path(_usable_folder(), name)
        self._lock_path = self.path.with_suffix(".lock")
        self._lock = _locked_file(self._lock_path, name)
        try:
            self.path.unlink(missing_ok=True)
        except OSError as error:
            self._lock.close()
            raise _blocked(self.path, error) from None

    def close(self) -> None:
        """Remove the files and release the name; further calls have no effect."""
        if not self._lock.closed:
            self.path.unlink(missing_ok=True)
            self._lock_path.unlink(missing_ok=True)
            self._lock.close()


def _usable_folder() -> Path:
    """Return the first folder that is private to this user; create it if necessary."""
    problem: str | None = ""
    for folder in folders():
        try:
            folder.mkdir(mode=0o700, exist_ok=True)
            problem = insecurity(folder)
        except OSError as error:
            problem = f"{folder}: {error.strerror}"
        if problem is None and not os.access(folder, os.W_OK | os.X_OK):
            problem = f"{folder} cannot be written"
        if problem is None:
            return folder
    raise TransportError(f"no private folder for the socket: {problem}")


def _locked_file(path: Path, name: str) -> IO[str]:
    """Lock the lock file, write the id of this process to it, and return it."""
    import fcntl  # this module does not exist on Windows

    while True:
        try:
            file = path.open("a+", encoding="ascii")
        except OSError as error:
            raise _blocked(path, error) from None
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.seek(0)
            pid = file.read().strip() or "unknown"
            file.close()
            raise TransportError(
                f"another bringup named '{name}' is running (pid {pid}); "
                "stop it or use --name"
            ) from None
        # The last owner may have unlinked the file after it was opened and before it
        # was locked.
        try:
            is_current = path.stat().st_ino == os.fstat(file.fileno()).st_ino
        except FileNotFoundError:
            is_current = False
        if is_current:
            break
        file.close()
    file.truncate(0)
    file.write(f"{os.getpid()}\n")
    file.flush()
    return file


def _blocked(path: Path, error: OSError) -> TransportError:
    return TransportError(f"cannot use {path}: {error.strerror}")
