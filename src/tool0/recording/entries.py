"""Events and requests in a recording: the data that is not stored in arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedEvent:
    """A recorded event, such as the end of a goal, a warning, a fault or a reset."""

    time: float
    """Simulated time [s]."""
    kind: str
    """Code of the event, such as ``goal_succeeded``, which is also used in the panel's
    notices."""
    severity: str
    """Severity: ``info``, ``warning`` or ``error``."""
    text: str
    """Description of the event."""
    data: Mapping[str, Any]
    """Details of the event by name."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedRequest:
    """A request that changed the simulation and was executed between two ticks."""

    step: int
    """Number of ticks from the bring-up to the tick before which the request was
    executed."""
    tick: int
    """Number of ticks from the start or the last reset to the tick before which the
    request was executed."""
    number: int
    """Index of the request in the journal, starting at 0."""
    time: float
    """Simulated time [s]."""
    method: str
    """Name of the request's method in the protocol."""
    params: Mapping[str, Any] | None
    """Parameters of the request; None if they could not be written."""
    error: str | None = None
    """Reason why the request was refused; None if it succeeded."""
    unrepeatable: str | None = None
    """Reason why the parameters could not be written; None if they were written."""
