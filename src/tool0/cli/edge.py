"""The process-wide behavior of the command line: signals, standard streams and errors.

After a failure of the environment (a full disk, no free file descriptors, a closed
output), a command prints a one-line message and ends with an exit status.  Only a bug
results in a traceback.
"""

from __future__ import annotations

import codecs
import errno
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TextIO


def open_standard_streams() -> None:
    """Reopen closed standard streams, and make all standard streams accept any text.

    Open streams prevent other files from using the descriptors of the standard
    streams.  Writing to a closed standard output fails, as in other programs.
    """
    for number, (name, mode) in enumerate(_STREAMS.items()):
        try:
            os.fstat(number)
        except OSError:
            flags = os.O_WRONLY if name == "stderr" else os.O_RDONLY
            os.set_inheritable(os.open(os.devnull, flags), True)
        if getattr(sys, name) is None:
            stream = open(number, mode, encoding="utf-8", closefd=False)  # noqa: SIM115
            setattr(sys, name, stream)
    codecs.register_error("plain", _plain)
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="plain")  # type: ignore[union-attr]


_STREAMS = {"stdin": "r", "stdout": "w", "stderr": "w"}
_PLAIN = {
    **{"│": "|", "├": "|", "└": "`", "─": "-", "…": "...", "·": ".", "→": "->"},
    **{"°": "deg", "≥": ">=", "≤": "<=", "²": "^2", "\N{MINUS SIGN}": "-"},
    "\N{MULTIPLICATION SIGN}": "x",
}


def _plain(error: UnicodeError) -> tuple[str | bytes, int]:
    """Replace an unencodable character with ASCII characters."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    character = error.object[error.start]
    if character in _PLAIN:
        return _PLAIN[character], error.start + 1
    error.end = error.start + 1
    return codecs.backslashreplace_errors(error)


@contextmanager
def interruptible() -> Iterator[None]:
    """Make Ctrl-C raise KeyboardInterrupt instead of ending the process immediately."""
    if signal.getsignal(signal.SIGINT) is not signal.SIG_DFL:
        yield
        return
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.SIG_DFL)


def flush() -> None:
    """Flush the output while a failure can still be reported."""
    _discard_unwritten(sys.stderr)  # a failure of stderr cannot be reported
    if sys.stdout is not None:
        sys.stdout.flush()


def report(error: Exception) -> bool:
    """Print the error in one line.  For a broken pipe, print nothing and return False.

    Raises:
        Exception: The given ``error``, if the error is a bug.
    """
    from tool0.errors import Tool0Error

    _discard_unwritten(sys.stdout)
    match error:
        case Tool0Error() | ImportError() | UnicodeError():
            text = str(error)
        case BrokenPipeError():
            return False  # such as `tool0 describe tree | head`: the reader has ended
        case OSError():
            text = _described(error)
        case MemoryError():
            text = "out of memory"
        case _:
            raise error
    with suppress(OSError):
        print(f"tool0: error: {text}", file=sys.stderr, flush=True)
    _discard_unwritten(sys.stderr)
    return True


def _discard_unwritten(stream: TextIO | None) -> None:
    """Flush a stream; if this fails, prevent another flush at exit."""
    try:
        if stream is not None:
            stream.flush()
    except OSError:
        assert stream is not None
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, stream.fileno())
        os.close(null)


def _described(error: OSError) -> str:
    where, reason = error.filename, error.strerror or str(error)
    if error.errno in (errno.EMFILE, errno.ENFILE):
        reason += "; let the process open more files (`ulimit -n`)"
    elif where is None and error.errno in (errno.ENOSPC, errno.EBADF, errno.EIO):
        where = "cannot write the output"
    return reason if where is None else f"{where}: {reason}"
