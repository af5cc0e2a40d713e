"""Messages of the primary interface: versions, texts, popups, errors and programs.

Source of the layouts:
https://docs.universal-robots.com/tutorials/communication-protocol-tutorials/primary-secondary-guide.html
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from struct import Struct
from typing import Final

ROBOT_MESSAGE: Final = 20
MAX_TEXT: Final = 8192
"""Maximum length of a text [bytes]. Longer texts are truncated, because the buffers of
clients have a limited size."""
MAX_TITLE: Final = 255
_HEADER: Final = Struct(">iBQbB")
"""Header of a packet: size, type, timestamp, source and kind of message."""


class Source(IntEnum):
    """Source of a message."""

    ROBOT_INTERFACE = -2
    REAL_TIME_MACHINE = -3


class Kind(IntEnum):
    """Kind of a message."""

    TEXT = 0
    POPUP = 2
    VERSION = 3
    SAFETY_MODE = 5
    ERROR_CODE = 6
    KEY = 7
    RUNTIME_EXCEPTION = 10


class ReportLevel(IntEnum):
    """Severity of an error; ``VIOLATION`` means that the program has failed."""

    WARNING = 2
    VIOLATION = 3


PROGRAM_STARTED: Final = "PROGRAM_XXX_STARTED"
PROGRAM_STOPPED: Final = "PROGRAM_XXX_STOPPED"
_UNSIGNED_DATA: Final = 1
"""Type code of the data field in a message: an unsigned integer."""


def version_message(version: Sequence[int], build_date: str) -> bytes:
    """Return the first packet of a connection, which contains the version numbers."""
    name = b"URControl"
    major, minor, bugfix = version
    numbers = Struct(f">b{len(name)}sBBii").pack(
        len(name), name, major, minor, bugfix, 0
    )
    return _message(0.0, Kind.VERSION, numbers + build_date.encode())


def text_message(time: float, text: str) -> bytes:
    """Return the message for a line of ``textmsg``; ``time`` is simulated time [s]."""
    return _message(time, Kind.TEXT, _cut(text))


def popup_message(
    time: float, title: str, text: str, *, is_warning: bool, is_error: bool
) -> bytes:
    """Return the message that shows a popup; the popup requires no answer."""
    heading = _cut(title, MAX_TITLE)
    head = Struct(">IB???B").pack(0, 0, is_warning, is_error, False, len(heading))
    return _message(time, Kind.POPUP, head + heading + _cut(text))


def key_message(time: float, title: str, text: str) -> bytes:
    """Return the message for the start or end of a program."""
    heading = _cut(title, MAX_TITLE)
    head = Struct(">iiB").pack(0, 0, len(heading))
    return _message(time, Kind.KEY, head + heading + _cut(text))


def exception_message(time: float, place: tuple[int, int], text: str) -> bytes:
    """Return the message for an error at a line and column, which start at 1."""
    head = Struct(">ii").pack(*place)
    return _message(
        time, Kind.RUNTIME_EXCEPTION, head + _cut(text), Source.REAL_TIME_MACHINE
    )


def error_message(time: float, text: str, code: int, *, is_warning: bool) -> bytes:
    """Return a robot error; ``code`` is UR's error number, or 0 if there is none."""
    level = ReportLevel.WARNING if is_warning else ReportLevel.VIOLATION
    head = Struct(">iiiII").pack(code, 0, level, _UNSIGNED_DATA, 0)
    return _message(time, Kind.ERROR_CODE, head + _cut(text), Source.REAL_TIME_MACHINE)


def safety_message(time: float, mode: int) -> bytes:
    """Return the message for a change of the safety mode."""
    body = Struct(">iiBII").pack(0, 0, mode, _UNSIGNED_DATA, 0)
    return _message(time, Kind.SAFETY_MODE, body, Source.REAL_TIME_MACHINE)


def _message(
    time: float, kind: Kind, body: bytes, source: Source = Source.ROBOT_INTERFACE
) -> bytes:
    nanoseconds = max(0, round(time * 1e9))
    size = _HEADER.size + len(body)
    return _HEADER.pack(size, ROBOT_MESSAGE, nanoseconds, source, kind) + body


def _cut(text: str, limit: int = MAX_TEXT) -> bytes:
    """Return UTF-8 text of at most ``limit`` bytes, without split characters."""
    return text.encode(errors="replace")[:limit].decode(errors="ignore").encode()
