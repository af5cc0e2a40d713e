"""The request table: the operations on a running robot, and their handlers.

A request is a frozen struct.  Its fields state their units and bounds, its type
parameter is the response, and one handler carries it out.  The Python handles, the
Unix socket, the panel's WebSocket, ROS 1 and the command line create requests and
contain no logic of their own.
"""

from __future__ import annotations

import math
import re
import typing
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import cache
from numbers import Integral, Real
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Generic, TypeVar, final

import msgspec
from msgspec import Meta

from tool0.errors import RequestError

if TYPE_CHECKING:
    from tool0.runtime.simulation import Simulation

Response = TypeVar("Response")


class Request(
    msgspec.Struct,
    Generic[Response],
    frozen=True,
    kw_only=True,
    forbid_unknown_fields=True,
):
    """One operation on a running robot, answered by a ``Response``."""

    unchecked: ClassVar[tuple[str, ...]] = ()
    """Fields that the handler checks itself: large ones, as a trajectory's points."""


RequestType = TypeVar("RequestType", bound=Request[Any])
Handler = Callable[..., Any]
"""Called with the simulation and the request, and with what was prepared, if it was."""
Prepare = Callable[["Simulation", Any], Any]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """One row of the table."""

    name: str
    """The method's name on a connection: the class's name in snake_case."""
    request: type[Request[Any]]
    handler: Handler
    in_tick: bool
    """Whether the handler runs in the thread of the tick, between two ticks: quick, and
    with the engine and the controllers at hand.  Otherwise it runs in the
    caller's thread, and may take longer."""
    changes: bool
    """Whether it changes the simulation.  Only handlers ``in_tick`` may: each one is
    noted in the journal, from which a session can be repeated.  Others plan, and then
    answer such a request."""
    prepare: Prepare | None
    """Called before an ``in_tick`` handler, in the caller's thread: what takes long and
    depends on nothing that moves.  The handler gets its result."""
    publishes: bool
    """Whether a snapshot follows, so that the next reader sees the effect."""
    is_urgent: bool
    """Whether it is a stop: it overtakes everything that waits, on its connection, for
    a worker and for the tick."""
    revokes: tuple[str, ...]
    """Methods that undo a stop.  Those that its connection sent before it and that wait
    are refused, for the same arm; if one is in progress, the stop follows it."""
    is_streamed: bool
    """Whether many of them follow each other without replies: each is executed at the
    next tick, without a detour through other threads."""
    is_local: bool
    """Whether the response only makes sense inside the process."""

    @property
    def response(self) -> Any:
        """The response's type, resolved."""
        return _response_type(self.request)


_BY_TYPE: dict[type[Request[Any]], Entry] = {}
_BY_NAME: dict[str, Entry] = {}


def handles(
    request: type[RequestType],
    *,
    in_tick: bool = False,
    changes: bool | None = None,
    prepare: Prepare | None = None,
    publishes: bool | None = None,
    urgent: bool = False,
    revokes: tuple[str, ...] = (),
    streamed: bool = False,
    local: bool = False,
) -> Callable[[Handler], Handler]:
    """Register the decorated function as the handler of ``request``, with a new name.

    The options are those of ``Entry``.  Left out, ``publishes`` is as ``in_tick``, and
    ``changes`` as that, or as ``streamed``.
    """
    name = method_name(request)
    publishes = in_tick if publishes is None else publishes
    changes = in_tick and (publishes or streamed) if changes is None else changes
    if name in _BY_NAME:
        raise TypeError(f"request '{name}' has a handler already")
    if not in_tick and (changes or prepare is not None):
        raise TypeError(f"request '{name}': only a handler in the tick changes things")

    def register(handler: Handler) -> Handler:
        _BY_TYPE[request] = _BY_NAME[name] = Entry(
            name=name,
            request=request,
            handler=handler,
            in_tick=in_tick,
            changes=changes,
            prepare=prepare,
            publishes=publishes,
            is_urgent=urgent,
            revokes=revokes,
            is_streamed=streamed,
            is_local=local,
        )
        return handler

    return register


def method_name(request: type[Request[Any]]) -> str:
    """Return the name on a connection: ``MoveJoints`` is ``move_joints``."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", request.__name__).lower()


def entry_of(request: type[Request[Any]]) -> Entry:
    """Return the row of a request class; KeyError if it has no handler."""
    load_all()
    return _BY_TYPE[request]


def entries() -> Mapping[str, Entry]:
    """Return the whole table, by method name."""
    load_all()
    return _BY_NAME


_MODULES = (
    *(
        "arm",
        "arm_motion",
        "control_box",
        "gripper",
        "hardware",
        "motion",
        "objects",
        "program",
        "replay",
        "sensors",
        "state",
        "stream_watch",
    ),
    "updates",
)


_MODULES_ABOVE = ("recording.requests", "recording.episodes")
"""Of packages that use the requests of this one."""


@cache
def load_all() -> None:
    """Import every module that declares requests of our own."""
    from importlib import import_module

    for module in (*(f"requests.{name}" for name in _MODULES), *_MODULES_ABOVE):
        import_module(f"tool0.{module}")


# ---- types of fields -------------------------------------------------------------

Name = Annotated[str, Meta(min_length=1, max_length=200)]
"""Of a controller, a joint, a link, a pose …"""
SpeedScale = Annotated[float, Meta(ge=0.01, le=1.0)]
"""Fraction of each joint's largest velocity."""
Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""w, x, y, z."""
RGBA = tuple[float, float, float, float]
Length = Annotated[float, Meta(gt=0.0, le=1000.0)]
"""[m]"""
Coordinate = Annotated[float, Meta(ge=-1000.0, le=1000.0)]
"""[m]"""
Place = tuple[Coordinate, Coordinate, Coordinate]
JointPositions = Annotated[dict[str, float], Meta(max_length=1000)]
"""Joint → position [rad | m]."""


# ---- checking ------------------------------------------------------------------------


def checked(request: RequestType) -> RequestType:
    """Return ``request`` with plain values, or raise what is wrong with one of them.

    numpy's numbers and arrays become Python's, and every value is compared with the
    type and the bounds of its field, as it is when it arrives on a connection.

    Raises:
        RequestError: If a value has the wrong type, is not finite, or is out of bounds.
    """
    kind = type(request)
    values = {}
    for field, annotation in _field_types(kind).items():
        value = getattr(request, field)
        if field not in kind.unchecked:
            value = checked_value(method_name(kind), field, value, annotation)
        values[field] = value
    return kind(**values)


def checked_value(method: str, name: str, value: object, kind: Any) -> Any:
    """Return ``value`` as one of type ``kind``, or raise RequestError.

    Args:
        method: What the value is given to, for the message.
        name: The name of the parameter.
        value: The value.
        kind: A type, with bounds.
    """
    try:
        return msgspec.convert(plain(value), kind)
    except (ValueError, TypeError, OverflowError, RecursionError) as error:
        raise RequestError(method, f"'{name}': {error}") from None


def plain(value: Any, key: object = None) -> Any:
    """Return ``value`` made of Python's own numbers and sequences, all finite.

    Raises:
        ValueError: If a number is NaN or infinite; with its ``key`` in a mapping.
    """
    match value:
        case None | bool() | str() | bytes():
            return value
        case msgspec.Struct():
            return _plain_struct(value)
        case Integral():
            return int(value)
        case Real():
            if not math.isfinite(value):
                of = "" if key is None else f"'{key}' "
                raise ValueError(f"{of}must be finite, got {value}")
            return float(value)
        case Mapping():
            return {key: plain(item, key) for key, item in value.items()}
        case Sequence() | Set():
            return [plain(item, key) for item in value]
    return value.tolist() if hasattr(value, "tolist") else value


def _plain_struct(value: msgspec.Struct) -> Any:
    """Return a structure as the mapping that a connection brings."""
    kind = value.__struct_config__
    found: dict[str, Any] = {}
    if kind.tag_field is not None:
        found[kind.tag_field] = kind.tag
    for name, encoded in zip(
        value.__struct_fields__, value.__struct_encode_fields__, strict=True
    ):
        found[encoded] = plain(getattr(value, name), encoded)
    return found


@cache
def _field_types(kind: type[Request[Any]]) -> Mapping[str, Any]:
    hints = typing.get_type_hints(kind, include_extras=True)
    return {field: hints[field] for field in kind.__struct_fields__}


@cache
def _response_type(kind: type[Request[Any]]) -> Any:
    for parent in kind.__mro__:
        for base in parent.__dict__.get("__orig_bases__", ()):
            if isinstance(argument := (*typing.get_args(base), None)[0], TypeVar):
                continue
            if issubclass(typing.get_origin(base) or object, Request):
                return argument
    raise TypeError(f"{kind.__name__} does not say what its response is")


# ---- answering -----------------------------------------------------------------------


def answer(simulation: Simulation, request: Request[Response]) -> Response:
    """Carry out ``request`` and return its response, or raise what the handler raises.

    The request's values were checked before.
    """
    entry = entry_of(type(request))
    if entry.in_tick:
        prepared = _prepared(simulation, entry, request)
        response: Response = simulation.loop.call(
            lambda: _execute(simulation, entry, request, prepared),
            publishes=entry.publishes,
            urgent=entry.is_urgent,
        )
        return response
    response = entry.handler(simulation, request)
    return response


def post(
    simulation: Simulation,
    request: Request[Any],
    when_failed: Callable[[Exception], None],
) -> None:
    """Let the next tick carry out a request of a stream; return at once.

    ``when_failed`` is called with an exception of its handler, in the thread of the
    tick.
    """
    entry = entry_of(type(request))
    prepared = _prepared(simulation, entry, request)
    simulation.loop.post(
        lambda: _execute(simulation, entry, request, prepared), when_failed
    )


def _prepared(
    simulation: Simulation, entry: Entry, request: Request[Any]
) -> tuple[Any, ...]:
    """Return the further arguments of a handler."""
    prepare = entry.prepare
    return () if prepare is None else (prepare(simulation, request),)


def _execute(
    simulation: Simulation,
    entry: Entry,
    request: Request[Any],
    prepared: tuple[Any, ...],
) -> Any:
    """Call a handler between two ticks, and note in the journal what it changes."""
    if not entry.changes:
        return entry.handler(simulation, request, *prepared)
    note = simulation.journal.begin(request)
    try:
        response = entry.handler(simulation, request, *prepared)
    except Exception as error:
        note(error)
        raise
    note(None)
    return response
