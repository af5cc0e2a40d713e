"""The edge of the process: its signals, its standard streams, and its errors.

A failure of the environment (a full disk, no descriptors, a closed output) ends a
command with one line and an exit status.  Only bugs have tracebacks.
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
    """Reopen closed standard streams, and make all of them accept any text.

    Other files can then no longer take their descriptors.  Writing to a closed standard
    output fails, as in other programs.
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
    """Replace characters that an encoding lacks, mostly ASCII, by similar ones."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    character = error.object[error.start]
    if character in _PLAIN:
        return _PLAIN[character], error.start + 1
    error.end = error.start + 1
    return codecs.backslashreplace_errors(error)


@contextmanager
def interruptible() -> Iterator[None]:
    """Make Ctrl-C raise KeyboardInterrupt instead of ending the process at once."""
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
    _discard_unwritten(sys.stderr)  # there is nowhere to report it
    if sys.stdout is not None:
        sys.stdout.flush()


def report(error: Exception) -> bool:
    """Print the error in one line; return False if it is only a broken pipe.

    Raises:
        Exception: ``error`` again, if it is a bug.
    """
    from tool0.errors import Tool0Error

    _discard_unwritten(sys.stdout)
    match error:
        case Tool0Error() | ImportError() | UnicodeError():
            text = str(error)
        case BrokenPipeError():
            return False  # `tool0 describe tree | head`: the reader has finished
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
    """Flush a stream; if that fails, keep the interpreter from retrying at exit."""
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
