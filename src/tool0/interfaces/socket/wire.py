"""What goes over the socket: bounded lines of JSON, errors and results as objects."""

from __future__ import annotations

import json
import socket
from collections.abc import Mapping
from numbers import Integral, Real
from typing import Any, Final, final

from tool0 import errors
from tool0.control.goal import GoalResult, GoalStatus, GripperResult, Result
from tool0.errors import (
    DivergenceError,
    GoalRejectedError,
    Tool0Error,
    TransportError,
)

PROTOCOL: Final = 1
"""Raised by one when an old client could misunderstand a new server."""
MAX_LINE: Final = 1 << 20
"""Longest line [bytes], newline included; 10 000 waypoints of 6 joints fit."""
MAX_ANSWER: Final = 1 << 28
"""Longest line of the bringup, which its visitor trusts: the largest picture fits."""

Json = dict[str, Any]
"""An object as json gives it: Any, because the peer decides what is in it."""


@final
class LineTooLongError(TransportError):
    """A line longer than MAX_LINE: where it ends is unknown, so the stream is lost."""


@final
class LineReader:
    """Splits what a socket receives into lines, keeping a started line on timeout."""

    def __init__(self, peer: socket.socket, longest: int = MAX_LINE) -> None:
        self._peer = peer
        self._longest = longest
        self._buffer = bytearray()
        self._searched = 0

    def next_line(self) -> bytes | None:
        """Return a line without its newline, or None when the peer has closed.

        Raises:
            LineTooLongError: If no newline comes within ``longest`` bytes.
            TimeoutError: If the socket has a timeout, and it passed.
        """
        while True:
            end = self._buffer.find(b"\n", self._searched)
            if end >= 0:
                line = bytes(self._buffer[:end])
                del self._buffer[: end + 1]
                self._searched = 0
            if end >= self._longest or (end < 0 and len(self._buffer) >= self._longest):
                raise LineTooLongError(
                    f"a line is longer than {self._longest} bytes; send fewer waypoints"
                )
            if end >= 0:
                return line
            self._searched = len(self._buffer)
            received = self._peer.recv(65536)
            if not received:
                return None
            self._buffer += received


def encode(message: Mapping[str, object], longest: int = MAX_LINE) -> bytes:
    """Return ``message`` as one line.

    Infinity and NaN travel as Python's json writes them, so that a value is refused
    by the same check, with the same words, near and far.  numpy's numbers are numbers.

    Raises:
        LineTooLongError: If the line is longer than ``longest`` [bytes].
        TransportError: If something in the message is nothing that JSON has.
    """
    text = json.dumps(
        message, separators=(",", ":"), ensure_ascii=False, default=_as_json
    )
    line = text.encode() + b"\n"
    if len(line) > longest:
        raise LineTooLongError(
            f"a message of {len(line)} bytes is longer than {longest}; "
            "send fewer waypoints"
        )
    return line


def _as_json(value: object) -> float | int:
    match value:
        case Integral():
            return int(value)
        case Real():
            return float(value)
        case _:
            raise TransportError(f"need a number, a text or a list, got {value!r}")


def decode(line: bytes) -> Json:
    """Return the object in ``line``, or raise TransportError."""
    try:
        message = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise TransportError(f"a line is not JSON: {error}") from None
    if not isinstance(message, dict):
        raise TransportError(
            f"a line must hold a JSON object, got {type(message).__name__}"
        )
    return message


def error_to_json(error: BaseException) -> Json:
    """Return ``error`` as the peer reads it; only our own keep their type."""
    if not isinstance(error, Tool0Error):
        return {
            "type": "TransportError",
            "message": f"the bringup failed on this request: {error!r}",
        }
    known = next(kind for kind in type(error).__mro__ if kind in _ERRORS.values())
    answer: Json = {"type": known.__name__, "message": str(error)}
    if isinstance(error, GoalRejectedError):
        answer["code"] = error.code
    if isinstance(error, DivergenceError):
        answer.update(joint=error.joint, time=error.time)
    return answer


def error_from_json(answer: object) -> Tool0Error:
    """Return the error that ``error_to_json`` wrote."""
    if not isinstance(answer, dict) or not isinstance(answer.get("message"), str):
        return TransportError(f"the bringup answered with a broken error: {answer!r}")
    message: str = answer["message"]
    kind = _ERRORS.get(str(answer.get("type")), TransportError)
    if kind is GoalRejectedError:
        code = answer.get("code")
        return GoalRejectedError(
            message, code if isinstance(code, int) else GoalRejectedError.INVALID_GOAL
        )
    if kind is DivergenceError:
        return DivergenceError(
            str(answer.get("joint")), float(answer.get("time", "nan"))
        )
    return kind(message)


def result_to_json(result: Result) -> Json:
    """Return how a goal ended, as an object."""
    if isinstance(result, GoalResult):
        return {
            "type": "GoalResult",
            "status": result.status.value,
            "error_code": result.error_code,
            "error_string": result.error_string,
        }
    return {
        "type": "GripperResult",
        "status": result.status.value,
        "position": result.position,
        "effort": result.effort,
        "stalled": result.stalled,
        "reached_goal": result.reached_goal,
    }


def result_from_json(answer: Json) -> Result:
    """Return the result that ``result_to_json`` wrote."""
    try:
        fields = {key: value for key, value in answer.items() if key != "type"}
        fields["status"] = GoalStatus(fields["status"])
        if answer["type"] == "GoalResult":
            return GoalResult(**fields)
        return GripperResult(**fields)
    except (KeyError, TypeError, ValueError):
        raise TransportError(
            f"the bringup answered with a broken result: {answer!r}"
        ) from None


_ERRORS: Final[dict[str, type[Tool0Error]]] = {
    name: kind
    for name, kind in vars(errors).items()
    if isinstance(kind, type) and issubclass(kind, Tool0Error) and name[0] != "_"
}
"""Every class of the error tree by name."""
