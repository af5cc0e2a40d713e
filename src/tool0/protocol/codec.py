"""Requests, responses, errors and events as JSON, for all connections.

A request is ``{"id": 1, "method": "step", "params": {"ticks": 5}}``.  The reply to this
request is ``{"type": "reply", "id": 1, "result": 0.005}``, or has ``"error"`` instead
of ``"result"``.  A request without an id is answered only if it fails.  Values of the
type ``bytes`` are sent as base64 strings.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import Any, Final, Literal, NamedTuple, final

import msgspec
from msgspec import UNSET, Raw, Struct, UnsetType

from tool0 import errors
from tool0.errors import (
    DivergenceError,
    GoalRejectedError,
    RequestError,
    Tool0Error,
    TransportError,
    did_you_mean,
)
from tool0.protocol.goals import GoalResult, GripperResult, Result
from tool0.protocol.methods import methods
from tool0.protocol.request import (
    Request,
    method_name,
    plain,
    problem_text,
    response_type,
)
from tool0.protocol.sensors import CameraImage, Picture, image_of, picture_of
from tool0.protocol.state import Snapshot
from tool0.protocol.state_message import (
    SNAPSHOT_FIELDS,
    StateMask,
    StateMessage,
    snapshot_of,
    state_message,
)

PROTOCOL: Final = 3
"""Version of the protocol.  The version is incremented if programs for the old version
could misinterpret messages of the new version."""
_LONGEST_STOP: Final = 4096
"""Maximum size of a stop request that overtakes waiting requests [bytes].  A longer
stop request, such as one with a long reason, waits like any other request."""
_SHOWN: Final = 40
"""Maximum number of characters of an unknown word that is quoted in an error
message."""
UNREADABLE: Final = (msgspec.DecodeError, RecursionError, UnicodeDecodeError)
"""Exceptions for text that is not JSON, that is nested too deeply, or that is not
UTF-8."""


# ---- errors and outcomes -------------------------------------------------------------


class ErrorInfo(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """The error of a failed request."""

    type: str
    """Name of a class in tool0's exception hierarchy, such as ``ClaimError``."""
    message: str
    code: int | None = None
    """Error code of a GoalRejectedError."""
    joint: str | None = None
    """Joint of a DivergenceError."""
    time: float | None = None
    """Simulated time of a DivergenceError [s]."""


class Outcome(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """Result of a goal: a GoalResult, or a GripperResult with a position."""

    status: str
    error_code: int = 0
    error_string: str = ""
    position: float | None = None
    effort: float | None = None
    stalled: bool | None = None
    reached_goal: bool | None = None
    holds: bool | None = None


ERRORS: Final[dict[str, type[Tool0Error]]] = {
    name: kind
    for name, kind in vars(errors).items()
    if isinstance(kind, type) and issubclass(kind, Tool0Error) and name[0] != "_"
}
"""Name → error type, for the types that are preserved on a connection."""


def error_info(error: BaseException) -> ErrorInfo:
    """Return ``error`` in its sent form; only errors of tool0 keep their type."""
    if not isinstance(error, Tool0Error):
        return ErrorInfo(
            type="InternalError",
            message=f"the request failed with {error!r}; the bring-up's log says more",
        )
    known = next(kind for kind in type(error).__mro__ if kind in ERRORS.values())
    return ErrorInfo(
        type=known.__name__,
        message=str(error),
        code=error.code if isinstance(error, GoalRejectedError) else None,
        joint=error.joint if isinstance(error, DivergenceError) else None,
        time=error.time if isinstance(error, DivergenceError) else None,
    )


def error_of(info: ErrorInfo) -> Tool0Error:
    """Return the error that a received ``ErrorInfo`` describes."""
    kind = ERRORS.get(info.type, TransportError)
    if kind is GoalRejectedError:
        return GoalRejectedError(
            info.message,
            GoalRejectedError.INVALID_GOAL if info.code is None else info.code,
        )
    if kind is DivergenceError:
        return DivergenceError(str(info.joint), info.time or 0.0)
    if kind is RequestError:
        return RequestError(*info.message.split(": ", 1))
    return kind(info.message)


def outcome_of(result: Result) -> Outcome:
    """Return the sent form of a goal's result."""
    return msgspec.convert(msgspec.to_builtins(result), Outcome)


def result_of(outcome: Outcome) -> Result:
    """Return the result that a received ``Outcome`` describes."""
    plain_outcome = msgspec.to_builtins(outcome)
    if outcome.position is None:
        return msgspec.convert(plain_outcome, GoalResult)
    return msgspec.convert(plain_outcome, GripperResult)


# ---- messages other than replies and states ----------------------------------------

Mode = Literal["simulation", "hardware", "view", "replay"]


class Hello(Struct, frozen=True, kw_only=True, tag="hello"):
    """The server's first message on a connection."""

    protocol: int
    version: str
    """Version of tool0."""
    name: str
    """Name of the bring-up."""
    pid: int
    mode: Mode
    """``simulation``, ``hardware`` (a real robot), ``view`` (a robot without physics
    and controllers), or ``replay`` (a recording)."""


class GoalEnded(Struct, frozen=True, kw_only=True, tag="goal_finished"):
    """A goal has ended; sent to the goal's connection and to subscribers."""

    goal: int | None
    """Number of the goal; null if no request started it."""
    controller: str
    outcome: Outcome


class Fault(Struct, frozen=True, kw_only=True, tag="fault"):
    """The physics or a controller has failed: the simulation waits for a reset."""

    message: str
    time: float
    """Simulated time [s]."""


class ResetDone(Struct, frozen=True, kw_only=True, tag="reset"):
    """The robot and the objects were returned to their start poses."""

    time: float
    """Simulated time after the reset [s]."""


class LateTicks(Struct, frozen=True, kw_only=True, tag="overrun"):
    """The simulation is behind the wall clock, or has caught up again."""

    count: int
    """Number of ticks that started late in the last second; 0 if the simulation has
    caught up again."""
    time: float
    """Simulated time [s]."""


EventMessage = GoalEnded | Fault | ResetDone | LateTicks


# ---- requests and replies ------------------------------------------------------------


class Envelope(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A request as received, with undecoded parameters."""

    method: str
    id: int | str | None = None
    """Number or string that the reply repeats.  A request without an id is answered
    only if it fails."""
    params: Raw = Raw(b"{}")


class Reply(Struct, frozen=True, kw_only=True, tag="reply"):
    """The answer to one request."""

    id: int | str | None
    """Id of the request; null if no id could be read."""
    result: Raw | UnsetType = UNSET
    error: ErrorInfo | UnsetType = UNSET


class _WireForm(NamedTuple):
    """The sent form of a response that is not plain data."""

    kind: Any
    write: Callable[[Any], Any]
    read: Callable[[Any], Any]


_WIRE_FORMS: Final[Mapping[Any, _WireForm]] = {
    CameraImage: _WireForm(Picture, picture_of, image_of),
    Snapshot: _WireForm(
        StateMessage,
        partial(state_message, mask=StateMask(SNAPSHOT_FIELDS)),
        snapshot_of,
    ),
}


def wire_type(response: Any) -> Any:
    """Return the type in which a response of this type is sent."""
    form = _WIRE_FORMS.get(response)
    return response if form is None else form.kind


def _encodable(value: Any) -> Any:
    """Convert a value that msgspec does not support, such as a NumPy number."""
    found = plain(value)
    if found is value:
        raise TypeError(f"a value of type {type(value).__name__} cannot be sent")
    return found


_encoder = msgspec.json.Encoder(enc_hook=_encodable)
_envelopes = msgspec.json.Decoder(Envelope)


@final
class RequestReadError(Exception):
    """Raised for an invalid request; contains the id and the error for the reply."""

    def __init__(self, ident: int | str | None, error: Tool0Error) -> None:
        super().__init__(str(error))
        self.ident = ident
        self.error = error


def encode(message: Struct) -> bytes:
    """Return a message as JSON, without a newline."""
    return _encoder.encode(message)


def encode_request(ident: int | None, request: Request[Any]) -> bytes:
    """Return a request as JSON, without a newline.

    A request without ``ident`` is answered only if it fails.

    Raises:
        RequestError: If a value of the request cannot be sent.
    """
    method = method_name(type(request))
    try:
        return _encoder.encode({"id": ident, "method": method, "params": request})
    except (TypeError, ValueError, OverflowError) as error:
        raise RequestError(method, str(error)) from None


def may_be_urgent(text: bytes | str) -> bool:
    """Return whether the undecoded ``text`` may be a stop request."""
    if len(text) > _LONGEST_STOP:
        return False
    if isinstance(text, str):
        return any(name in text for name in _urgent_methods(len(methods())))
    return any(name.encode() in text for name in _urgent_methods(len(methods())))


def decode_request(
    text: bytes | str, *, suggests: bool = True
) -> tuple[int | str | None, Request[Any]]:
    """Return the id and the request in ``text``.

    Args:
        text: The message as received.
        suggests: Whether an error suggests similar names, and contains the id of a
            malformed request.  The search for names and ids takes longer than most
            requests.

    Raises:
        RequestReadError: If the text is not a valid request.
    """
    try:
        envelope = _envelopes.decode(text)
    except UNREADABLE as error:
        problem = (
            f'this is no request, {{"id": …, "method": …, "params": {{…}}}}: {error}'
        )
        ident = _id_in(text) if suggests else None
        raise RequestReadError(ident, TransportError(problem)) from None
    method = envelope.method
    kind = methods().get(method)
    if kind is None:
        near = did_you_mean(method[:_SHOWN], set(methods())) if suggests else ""
        problem = f"unknown method '{method[:_SHOWN]}'{near}"
        raise RequestReadError(envelope.id, TransportError(problem))
    try:
        return envelope.id, _decoder(kind).decode(envelope.params)
    except (*UNREADABLE, Tool0Error) as error:
        explained = _explained(kind, envelope.params, error, suggests=suggests)
        raise RequestReadError(envelope.id, explained) from None


def encode_reply(
    ident: int | str | None, request: Request[Any], response: Any
) -> bytes:
    """Return the reply to a request that succeeded."""
    form = _WIRE_FORMS.get(response_type(type(request)))
    result = _encoder.encode(response if form is None else form.write(response))
    return encode(Reply(id=ident, result=Raw(result)))


def encode_error(ident: int | str | None, error: BaseException) -> bytes:
    """Return the reply to a request that failed."""
    return encode(Reply(id=ident, error=error_info(error)))


def decode_response(request: Request[Any], result: Raw) -> Any:
    """Return the decoded response; raise TransportError if it is invalid."""
    response = response_type(type(request))
    form = _WIRE_FORMS.get(response)
    try:
        value = _decoder(response if form is None else form.kind).decode(result)
        return value if form is None else form.read(value)
    except (msgspec.DecodeError, ValueError) as error:
        raise TransportError(f"the answer is not as expected: {error}") from None


@cache
def _decoder(kind: Any) -> Any:
    return msgspec.json.Decoder(kind)


def _id_in(text: bytes | str) -> int | str | None:
    """Return the id of a malformed request, if it can be found."""
    try:
        given = msgspec.json.decode(text)
    except UNREADABLE:
        return None
    ident = given.get("id") if isinstance(given, dict) else None
    is_id = isinstance(ident, int | str) and not isinstance(ident, bool)
    return ident if is_id else None


@cache
def _urgent_methods(n_methods: int) -> tuple[str, ...]:
    """Return the names of stop requests; the result is cached by ``n_methods``."""
    return tuple(name for name, kind in methods().items() if kind.is_urgent)


def _explained(
    kind: type[Request[Any]], params: Raw, error: Exception, *, suggests: bool
) -> Tool0Error:
    """Return an error that describes the invalid parameter of a request."""
    if isinstance(error, Tool0Error):
        return error
    method = method_name(kind)
    try:
        given = msgspec.json.decode(params)
    except UNREADABLE as worse:
        return TransportError(f"{method}: {worse}")
    valid = set(kind.__struct_fields__)
    for field in given if isinstance(given, dict) else ():
        if field not in valid:
            near = did_you_mean(field[:_SHOWN], valid) if suggests else ""
            return RequestError(method, f"no field '{field[:_SHOWN]}'{near}")
    return RequestError(method, problem_text(error))
