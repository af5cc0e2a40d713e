"""Control updates: the lean stream for programs that publish every one of them."""

from __future__ import annotations

from tool0.errors import ControlError
from tool0.protocol.updates import (
    SubscribeUpdates,
)
from tool0.requests.table import handles
from tool0.runtime.simulation import Simulation


@handles(SubscribeUpdates)
def _only_on_connections(simulation: Simulation, request: SubscribeUpdates) -> None:
    raise ControlError("streams are for connections; here, use robot.subscribe()")
