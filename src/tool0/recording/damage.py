"""Converts all errors that a damaged recording can cause to RecordingError."""

from __future__ import annotations

import contextlib
import functools
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Protocol, TypeVar

import msgspec

from tool0.errors import RecordingError, Tool0Error

T = TypeVar("T")


class _WithPath(Protocol):
    @property
    def path(self) -> Path: ...


R = TypeVar("R", bound=_WithPath)

_CAUSES = (
    ArithmeticError,
    LookupError,
    OSError,
    Tool0Error,
    TypeError,
    ValueError,
    msgspec.MsgspecError,
    struct.error,
)
"""Errors that readers raise if a recording is damaged."""


@contextlib.contextmanager
def damage(file: Path, part: str) -> Iterator[None]:
    """Raise RecordingError, with the file and ``part``, if the part cannot be read."""
    try:
        yield
    except RecordingError:
        raise
    except _CAUSES as error:
        raise RecordingError(f"{file}: {part} cannot be read: {error}") from error


def reads(part: str) -> Callable[[Callable[[R], T]], Callable[[R], T]]:
    """Return a decorator for methods that read ``part`` of a recording."""

    def decorate(read: Callable[[R], T]) -> Callable[[R], T]:
        @functools.wraps(read)
        def checked(recording: R) -> T:
            with damage(recording.path, part):
                return read(recording)

        return checked

    return decorate
