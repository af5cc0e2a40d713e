"""The table of request handlers of a simulation, and their execution.

The decorator ``handles`` registers a handler at its definition.  Higher-level packages
register handlers of their own requests in the same table when they are imported.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

from tool0.errors import NotOfferedError
from tool0.protocol.methods import register
from tool0.protocol.request import Request, RequestType, Response, method_name

if TYPE_CHECKING:
    from tool0.simulation.simulation import Simulation


Handler = Callable[..., Any]
"""Function that handles a request.  The arguments are the simulation, the request, and
the result of ``prepare`` if the handler has a ``prepare`` function."""
Prepare = Callable[["Simulation", Any], Any]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """An entry of the table of handlers."""

    request: type[Request[Any]]
    handler: Handler
    in_tick: bool
    """Whether the handler runs in the thread of the tick, between two ticks.  A handler
    in the thread of the tick must be fast, and may use the engine and the controllers.
    Any other handler runs in the caller's thread and may take longer."""
    changes: bool
    """Whether the handler changes the simulation.  Only ``in_tick`` handlers may change
    the simulation: each call is recorded in the journal, which makes it possible to
    repeat a session.  Other handlers prepare a change, and then send a request that has
    an ``in_tick`` handler."""
    prepare: Prepare | None
    """Function that is called in the caller's thread before an ``in_tick`` handler, for
    slow computations that do not depend on moving bodies.  The handler receives the
    result."""
    publishes: bool
    """Whether a snapshot is published after the call, so that the effect is visible to
    the next reader."""


_BY_TYPE: dict[type[Request[Any]], Entry] = {}
_BY_NAME: dict[str, Entry] = {}


def handles(
    request: type[RequestType],
    *,
    in_tick: bool = False,
    changes: bool | None = None,
    prepare: Prepare | None = None,
    publishes: bool | None = None,
    local: bool = False,
) -> Callable[[Handler], Handler]:
    """Register the decorated function as the only handler of ``request``.

    The options are the fields of ``Entry``.  ``publishes`` defaults to ``in_tick``.
    ``changes`` defaults to True for an ``in_tick`` handler if the handler publishes or
    the request is streamed.  Connections do not accept a ``local`` request, which is
    useful only within the process.
    """
    name = method_name(request)
    publishes = in_tick if publishes is None else publishes
    if changes is None:
        changes = in_tick and (publishes or request.is_streamed)
    if name in _BY_NAME:
        raise TypeError(f"request '{name}' has a handler already")
    if not in_tick and (changes or prepare is not None):
        raise TypeError(f"request '{name}': only a handler in the tick changes things")

    if not local:
        register(request)

    def note(handler: Handler) -> Handler:
        _BY_TYPE[request] = _BY_NAME[name] = Entry(
            request=request,
            handler=handler,
            in_tick=in_tick,
            changes=changes,
            prepare=prepare,
            publishes=publishes,
        )
        return handler

    return note


def entry_of(request: type[Request[Any]]) -> Entry:
    """Return the table entry of a request class.

    Raises:
        NotOfferedError: If simulations do not offer the request.
    """
    entry = _BY_TYPE.get(request)
    if entry is None:
        raise NotOfferedError(f"a simulation does not offer '{method_name(request)}'")
    return entry


HANDLERS: Collection[type[Request[Any]]] = _BY_TYPE.keys()
"""The requests that a simulation answers."""


def entries() -> Mapping[str, Entry]:
    """Return the entire table, by method name."""
    return _BY_NAME


def answer(simulation: Simulation, request: Request[Response]) -> Response:
    """Execute ``request`` and return its response, or raise the handler's error.

    The values of the request must already have been checked.
    """
    entry = entry_of(type(request))
    if entry.in_tick:
        prepared = _prepared(simulation, entry, request)
        response: Response = simulation.loop.call(
            lambda: _execute(simulation, entry, request, prepared),
            publishes=entry.publishes,
            urgent=request.is_urgent,
        )
        return response
    response = entry.handler(simulation, request)
    return response


def post(
    simulation: Simulation,
    request: Request[Any],
    when_failed: Callable[[Exception], None],
) -> None:
    """Queue a request of a stream for the next tick, and return immediately.

    If the handler raises an exception, ``when_failed`` is called with the exception in
    the thread of the tick.
    """
    entry = entry_of(type(request))
    prepared = _prepared(simulation, entry, request)
    simulation.loop.post(
        lambda: _execute(simulation, entry, request, prepared), when_failed
    )


def _prepared(
    simulation: Simulation, entry: Entry, request: Request[Any]
) -> tuple[Any, ...]:
    """Return the additional arguments of a handler."""
    prepare = entry.prepare
    return () if prepare is None else (prepare(simulation, request),)


def _execute(
    simulation: Simulation,
    entry: Entry,
    request: Request[Any],
    prepared: tuple[Any, ...],
) -> Any:
    """Call a handler between two ticks, and record the request in the journal."""
    if not entry.changes:
        return entry.handler(simulation, request, *prepared)
    note = simulation.journal.begin(request.as_done())
    try:
        response = entry.handler(simulation, request, *prepared)
    except Exception as error:
        note(error)
        raise
    note(None)
    return response
