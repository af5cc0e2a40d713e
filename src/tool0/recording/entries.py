"""Events and requests in a recording: all that is not arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedEvent:
    """Something that happened: a goal that ended, a warning, a fault, a reset."""

    time: float
    """Simulated time [s]."""
    kind: str
    """A code such as ``goal_succeeded``, as the panel's notices have it."""
    severity: str
    """``info``, ``warning`` or ``error``."""
    text: str
    """Description of the event."""
    data: Mapping[str, Any]
    """Details, by name."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedRequest:
    """A request that changed the simulation, executed between two ticks."""

    step: int
    """Ticks since the bring-up, before which it was executed."""
    tick: int
    """Ticks since the start or the last reset."""
    number: int
    """Place in the journal, from 0 on."""
    time: float
    """Simulated time [s]."""
    method: str
    """Name of the request on a connection."""
    params: Mapping[str, Any] | None
    """None if they could not be written."""
    error: str | None = None
    """Why it was refused."""
    unrepeatable: str | None = None
    """Why its parameters could not be written."""
