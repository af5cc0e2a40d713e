"""The handlers of a simulation: one for each request, and when it is called.

A handler is registered by ``handles`` where it is defined.  Packages above register
those of their own requests in the same table, by being imported.
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
"""Called with the simulation and the request, and with what was prepared, if it was."""
Prepare = Callable[["Simulation", Any], Any]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """One row of the table."""

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
    """Called before an ``in_tick`` handler, in the caller's thread, for work that takes
    long and depends on nothing that moves.  The handler gets its result."""
    publishes: bool
    """Whether a snapshot follows, so that the next reader sees the effect."""


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
    """Register the decorated function as the handler of ``request``, with a new name.

    The options are those of ``Entry``.  Left out, ``publishes`` is as ``in_tick``, and
    ``changes`` as that, or as whether requests are streamed.  Connections do not take
    a ``local`` request: it makes sense inside the process only.
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
    """Return the row of a request class.

    Raises:
        NotOfferedError: If a simulation does not offer it.
    """
    entry = _BY_TYPE.get(request)
    if entry is None:
        raise NotOfferedError(f"a simulation does not offer '{method_name(request)}'")
    return entry


HANDLERS: Collection[type[Request[Any]]] = _BY_TYPE.keys()
"""The requests that a simulation answers."""


def entries() -> Mapping[str, Entry]:
    """Return the whole table, by method name."""
    return _BY_NAME


def answer(simulation: Simulation, request: Request[Response]) -> Response:
    """Carry out ``request`` and return its response, or raise the handler's error.

    The request's values were checked before.
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
    """Queue a request of a stream for the next tick; return at once.

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
    """Call a handler between two ticks, and note the request in the journal."""
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
