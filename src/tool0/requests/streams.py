"""Requests about streams: what a connection receives without asking again."""

from __future__ import annotations

from typing import Annotated, Any

from msgspec import Meta

from tool0.errors import ControlError
from tool0.requests.table import Request, handles
from tool0.runtime.simulation import MAX_SNAPSHOT_RATE, Simulation


class Subscribe(Request[None], frozen=True):
    """Receive every snapshot as a ``snapshot`` message, and events as they happen.

    A second request changes the rate.  A slow reader loses the oldest snapshots; the
    next one says how many.
    """

    rate: Annotated[float, Meta(gt=0.0, le=MAX_SNAPSHOT_RATE)] = 125.0
    """Snapshots per simulated second [Hz]: the next divisor of the control rate."""


class Unsubscribe(Request[None], frozen=True):
    """Receive no more snapshots and events."""


class SubscribeView(Request[None], frozen=True):
    """Receive ``view``, ``scene``, ``status``, ``frame`` and ``notice``: the panel.

    Frames come at most 60 times a second of wall time, the newest only.
    """


@handles(Subscribe)
@handles(Unsubscribe)
@handles(SubscribeView)
def _only_on_connections(simulation: Simulation, request: Any) -> None:
    raise ControlError("streams are for connections; here, use robot.subscribe()")
