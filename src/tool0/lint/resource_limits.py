"""Runs a function in a child process with limits of time and memory.

A user's xacro is a program, and ten lines of YAML can hold a billion values.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import select
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec, TypeVar

from tool0.errors import Tool0Error

R = TypeVar("R")
P = ParamSpec("P")

TIMEOUT = 10.0
"""[wall s]; the largest robots take a tenth of it."""
MEMORY = 2 << 30
"""[bytes] beyond what this process holds."""
_CHUNK = 1 << 20


class ResourceLimitError(Tool0Error):
    """The work was given up; the message says why."""


def run_limited(
    work: Callable[P, R],
    *arguments: P.args,
    **keywords: P.kwargs,
) -> R:
    """Return what ``work`` returns, which must be picklable.

    Where there is no fork (Windows), it is done here, without bounds.

    Raises:
        ResourceLimitError: If it takes too long, too much memory, or crashes.
        Exception: What it raises itself.
    """
    if not hasattr(os, "fork"):
        return work(*arguments, **keywords)
    end, start = os.pipe()
    child = os.fork()
    if not child:
        os.close(end)
        _work(start, lambda: work(*arguments, **keywords))
    os.close(start)
    try:
        packet = _receive(end)
    finally:
        os.close(end)
        with contextlib.suppress(ProcessLookupError):
            os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
    if not packet:
        raise ResourceLimitError(f"reading it crashed (status {status})")
    error, answer = pickle.loads(packet)  # our own child wrote it
    if error is not None:
        raise error
    result: R = answer
    return result


def _receive(end: int) -> bytes:
    packet, deadline = bytearray(), time.monotonic() + TIMEOUT
    while True:
        left = deadline - time.monotonic()
        if left <= 0.0 or not select.select([end], [], [], left)[0]:
            raise ResourceLimitError(
                f"reading it takes longer than {TIMEOUT:g} s: look for a number "
                "beyond measure, or for something that contains itself"
            )
        chunk = os.read(end, _CHUNK)
        if not chunk:
            return bytes(packet)
        packet += chunk


def _work(start: int, work: Callable[[], object]) -> None:
    """Do it in the child, send what comes of it, and end."""
    packet = b""
    try:
        _limit()
        packet = pickle.dumps((None, work()))
    except MemoryError:
        packet = pickle.dumps(
            (ResourceLimitError(f"reading it takes more than {MEMORY >> 20} MiB"), None)
        )
    except BaseException as error:  # the parent raises it
        packet = _as_picklable(error)
    finally:
        with contextlib.suppress(OSError), os.fdopen(start, "wb") as stream:
            stream.write(packet)
        os._exit(0)


def _limit() -> None:
    import faulthandler
    import resource

    faulthandler.disable()  # the parent reports a crash
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends us
    seconds = int(TIMEOUT) + 1  # also when the parent was killed
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    with contextlib.suppress(OSError, ValueError):
        pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[0]
        held = int(pages) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (held + MEMORY, held + MEMORY))


def _as_picklable(error: BaseException) -> bytes:
    error.__traceback__ = error.__cause__ = error.__context__ = None
    with contextlib.suppress(Exception):
        packet: bytes = pickle.dumps((error, None))
        pickle.loads(packet)  # errors may fail at it only here
        return packet
    text = f"{type(error).__name__}: {error}"
    return pickle.dumps((ResourceLimitError(f"reading it failed: {text}"), None))
