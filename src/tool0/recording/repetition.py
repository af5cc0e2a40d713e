"""The requests of a recording, carried out once more at their recorded steps."""

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
"""Requests that only decide when ticks are executed."""
_CHECKED: Final = (AddModel, AddObject, PlaceObject, Reset)
"""Requests that earlier versions carried out without looking for penetration."""


@final
class Repetition:
    """Carries out recorded requests in a simulation, which nobody else moves."""

    def __init__(self, simulation: Simulation, meshes: Mapping[str, Path]) -> None:
        """``meshes`` has where the recorded meshes are now, by their URIs."""
        self._simulation = simulation
        self._meshes = meshes
        self.n_requests = 0
        """Requests that were carried out again."""
        self.notes: list[str] = []
        """Descriptions of the requests that could not be repeated."""

    def advance(self, step: int) -> None:
        """Advance to the tick of a step; after a fault not until a reset.

        Raises:
            Exception: Whatever the physics or a controller raised.
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
        """Carry out a request; return why it failed, or None.

        One that cannot be repeated, or only concerns time, ends as it was recorded.
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
        """Return a request; None, with a note, if it cannot be repeated."""
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
        if recorded.error is None:  # one that failed changed nothing
            self.notes.append(
                f"{recorded.method} at {recorded.time:.3f} s cannot be repeated: "
                f"{problem}"
            )
        return None

    def _as_accepted(
        self, request: Request[Any], recorded: RecordedRequest
    ) -> Request[Any]:
        """Return a request with the meshes of now; what was accepted is accepted."""
        if isinstance(request, AddObject):
            shape = with_meshes(request.shape, self._meshes)
            request = msgspec.structs.replace(request, shape=shape)
        if recorded.error is None and isinstance(request, _CHECKED):
            request = msgspec.structs.replace(request, allow_penetration=True)
        return request
