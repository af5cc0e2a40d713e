"""A backend that lacks some requests of a simulation, and notes for what it is used."""

from collections.abc import Callable, Collection
from typing import Any, Final, final

from tool0.protocol.backend import Backend, States
from tool0.protocol.request import Request


@final
class Lacking:
    """It never gets a request that it lacks, in a test that passes."""

    mode: Final = "simulation"

    def __init__(
        self, simulation: Backend, lacks: Collection[type[Request[Any]]], reason: str
    ) -> None:
        self._simulation = simulation
        self._lacks, self._reason = lacks, reason
        self.used: list[Request[Any]] = []

    @property
    def states(self) -> States | None:
        return self._simulation.states

    def why_missing(self, request: type[Request[Any]]) -> str:
        if request in self._lacks:
            return self._reason
        return self._simulation.why_missing(request)

    def answer(self, request: Request[Any]) -> Any:
        self.used.append(request)
        return self._simulation.answer(request)

    def post(
        self, request: Request[Any], when_failed: Callable[[Exception], None]
    ) -> None:
        self.used.append(request)

    def check_setpoint(self, request: Request[Any]) -> None:
        self.used.append(request)

    def superseded(self, request: Request[Any]) -> Collection[str]:
        self.used.append(request)
        return ()
