"""Execution of a recording's requests at their recorded steps."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, final

import msgspec

from tool0.errors import RequestError, Tool0Error
from tool0.protocol.objects import AddModel, AddObject, PlaceObject, with_meshes
from tool0.protocol.request import Request
from tool0.protocol.running import Pause, Reset, Resume, SetSpeed, Step
from tool0.recording.entries import RecordedRequest
from tool0.simulation.handlers.journal_codec import request_of
from tool0.simulation.handlers.table import answer
from tool0.simulation.simulation import Simulation

_ABOUT_TIME: Final = (Pause, Resume, SetSpeed, Step)
"""Requests that affect only the wall time at which ticks are executed."""
_CHECKED: Final = (AddModel, AddObject, PlaceObject, Reset)
"""Requests that earlier versions executed without a check for penetration."""


@final
class Repetition:
    """Repetition of recorded requests in a simulation without other clients."""

    def __init__(self, simulation: Simulation, meshes: Mapping[str, Path]) -> None:
        """Prepare to repeat requests; ``meshes`` are the current mesh files by URI."""
        self._simulation = simulation
        self._meshes = meshes
        self.n_requests = 0
        """Number of requests that were executed again."""
        self.notes: list[str] = []
        """Descriptions of the requests that could not be repeated."""

    def advance(self, step: int) -> None:
        """Advance to the tick of a step, unless a fault stops the simulation.

        Raises:
            Exception: Any exception that the physics or a controller raises before the
                step is reached.
        """
        loop = self._simulation.loop
        left = step - loop.steps
        if left <= 0:
            return
        try:
            loop.run(left * loop.control_period)
        except Exception:
            if loop.steps < step:
                raise

    def repeat(self, recorded: RecordedRequest) -> str | None:
        """Execute a request; return the reason why it failed, or None.

        If a request cannot be repeated, or affects only the timing of ticks, its
        recorded outcome is returned.
        """
        request = self._request(recorded)
        if request is None or isinstance(request, _ABOUT_TIME):
            return recorded.error
        self.n_requests += 1
        try:
            answer(self._simulation, request)
        except Tool0Error as failure:
            return str(failure)
        return None

    def _request(self, recorded: RecordedRequest) -> Request[Any] | None:
        """Return a request, or record that it cannot be repeated and return None."""
        problem = recorded.unrepeatable
        if problem is None:
            try:
                request = request_of(
                    recorded.method, msgspec.json.encode(recorded.params)
                )
            except RequestError as error:
                problem = str(error)
            else:
                return self._as_accepted(request, recorded)
        if recorded.error is None:  # a failed request had no effect
            self.notes.append(
                f"{recorded.method} at {recorded.time:.3f} s cannot be repeated: "
                f"{problem}"
            )
        return None

    def _as_accepted(
        self, request: Request[Any], recorded: RecordedRequest
    ) -> Request[Any]:
        """Return a request with current mesh files.

        A request that was accepted may cause penetration.
        """
        if isinstance(request, AddObject):
            shape = with_meshes(request.shape, self._meshes)
            request = msgspec.structs.replace(request, shape=shape)
        if recorded.error is None and isinstance(request, _CHECKED):
            request = msgspec.structs.replace(request, allow_penetration=True)
        return request
