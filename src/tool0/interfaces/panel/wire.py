"""From text to messages and back.  Whatever a page sends, it gets an answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final, get_args

import msgspec

from tool0.errors import Tool0Error, did_you_mean
from tool0.interfaces.panel.protocol import ClientMessage, Problem, Reply, ServerMessage

LONGEST: Final = 65536
"""Characters of a message; the largest that makes sense has some thousands."""
_SHOWN: Final = 40
"""Characters of a wrong word that an answer repeats."""
_FIELDS: Final = {
    str(kind.__struct_config__.tag): kind.__struct_fields__
    for kind in get_args(ClientMessage)
}
_decoder = msgspec.json.Decoder(ClientMessage)
_encoder = msgspec.json.Encoder()


@final
@dataclass(frozen=True, slots=True)
class Unreadable:
    """What came instead of a message, as the answer to it."""

    reply: Reply


def encode(message: ServerMessage) -> str:
    """Return what is sent."""
    return _encoder.encode(message).decode()


def decode(text: str | None) -> ClientMessage | Unreadable:
    """Return the message in ``text``; None for what was no text."""
    if text is None:
        return _unreadable(None, "a binary message came; send JSON as text")
    if len(text) > LONGEST:
        return _unreadable(
            None,
            f"the message has {len(text)} characters; a message may have {LONGEST}",
        )
    try:
        message: ClientMessage = _decoder.decode(text)
    except (msgspec.DecodeError, RecursionError) as error:
        return _explained(text, str(error))
    return message


def problem_of(error: Exception) -> Problem:
    """Return an error as the page is told of it."""
    if isinstance(error, Tool0Error):
        return Problem(kind=type(error).__name__, message=str(error))
    return Problem(
        kind="InternalError", message="the server made a mistake; its log says more"
    )


def _explained(text: str, why: str) -> Unreadable:
    """Say what would be right, where that can be told."""
    try:
        given = msgspec.json.decode(text)
    except (msgspec.DecodeError, RecursionError) as error:
        return _unreadable(None, f"this is no JSON: {error}")
    if not isinstance(given, dict):
        return _unreadable(None, "a message is a JSON object with its name in 'type'")
    number = given.get("id")
    is_id = isinstance(number, int) and not isinstance(number, bool) and number >= 0
    id_ = number if is_id else None
    kind = given.get("type")
    if not isinstance(kind, str):
        return _unreadable(id_, "a message has its name in 'type', as text")
    if kind not in _FIELDS:
        hint = did_you_mean(kind[:_SHOWN], set(_FIELDS))
        return _unreadable(id_, f"unknown type '{kind[:_SHOWN]}'{hint}")
    valid = {"type", *_FIELDS[kind]}
    for field in given:
        if field not in valid:
            hint = did_you_mean(field[:_SHOWN], valid)
            return _unreadable(id_, f"'{kind}' has no field '{field[:_SHOWN]}'{hint}")
    return _unreadable(id_, f"'{kind}': {why}")


def _unreadable(id_: int | None, message: str) -> Unreadable:
    return Unreadable(
        Reply(id=id_, error=Problem(kind="TransportError", message=message))
    )
