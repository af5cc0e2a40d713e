"""Repeating a recording: the same robot, the same requests at the same steps.

A simulation is deterministic between requests, so that every frame must come out as it
was recorded, bit by bit.  Where it does not, the reasons that can be found are named.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, final

import msgspec

from tool0.errors import RecordingError, RequestError, Tool0Error
from tool0.protocol.objects import AddModel, AddObject, PlaceObject, with_meshes
from tool0.protocol.request import Request
from tool0.protocol.running import Pause, Reset, Resume, SetSpeed, Step
from tool0.recording.comparison import DivergedError, Divergence, Frames
from tool0.recording.entries import RecordedRequest
from tool0.recording.reading import RecordingFile, open_recording
from tool0.simulation.handlers.journal_codec import request_of
from tool0.simulation.handlers.reproduction import restarted
from tool0.simulation.handlers.table import answer
from tool0.simulation.provenance import (
    current_platform,
    current_versions,
    is_deterministic,
)
from tool0.simulation.simulation import Simulation

_ABOUT_TIME: Final = (Pause, Resume, SetSpeed, Step)
"""Requests that only decide when ticks are executed."""
_CHECKED: Final = (AddModel, AddObject, PlaceObject, Reset)
"""Requests that earlier versions carried out without looking for penetration."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Resimulation:
    """The outcome of repeating a recording."""

    frames: int
    """Frames that came out bit-identically."""
    total_frames: int
    """Frames of the recording."""
    requests: int
    """Requests that were carried out again."""
    divergence: Divergence | None
    reasons: tuple[str, ...]
    """Why it may differ, or does: in words."""

    @property
    def is_identical(self) -> bool:
        """Whether every frame came out bit-identically."""
        return self.divergence is None and self.frames == self.total_frames


def resimulate(
    recording: RecordingFile | Path | str,
    when_compared: Callable[[int, int], None] = lambda done, total: None,
) -> Resimulation:
    """Repeat a recording and compare every frame; stop at the first that differs.

    Time, position, velocity and effort of every joint are compared, and the poses of
    the objects.

    Args:
        recording: What to repeat: one file, from its first frame to its last.
        when_compared: Called now and then with the frames compared and their total.

    Raises:
        RecordingError: If the file is no recording, or lacks what repeats it.
        Tool0Error: If the robot cannot be brought up, as without its engine.
    """
    if not isinstance(recording, RecordingFile):
        recording = open_recording(recording)
    if not len(recording):
        raise RecordingError(f"{recording.path} has no snapshot to compare")
    with tempfile.TemporaryDirectory(prefix="tool0-again-") as folder:
        meshes = recording.robot.mesh_files
        simulation = restarted(recording.bringup, Path(folder), meshes)
        try:
            repetition = _Repetition(recording, simulation, meshes, when_compared)
            return repetition.run()
        finally:
            simulation.close()


@final
class _Repetition:
    """One run: frames and requests in the order of their steps."""

    def __init__(
        self,
        recording: RecordingFile,
        simulation: Simulation,
        meshes: Mapping[str, Path],
        when_compared: Callable[[int, int], None],
    ) -> None:
        self._recording = recording
        self._simulation = simulation
        self._meshes = meshes
        self._when_compared = when_compared
        self._frames = Frames(recording)
        self._reasons = list(_reasons(recording))
        self._n_requests = 0

    def run(self) -> Resimulation:
        divergence = None
        try:
            self._repeat()
        except DivergedError as diverged:
            divergence = diverged.divergence
        return Resimulation(
            frames=self._frames.done,
            total_frames=len(self._recording),
            requests=self._n_requests,
            divergence=divergence,
            reasons=tuple(self._reasons),
        )

    def _repeat(self) -> None:
        requests = sorted(self._recording.requests, key=lambda item: item.step)
        at, frames = 0, self._frames
        while not frames.is_done:
            step = frames.next_step
            if at < len(requests) and requests[at].step <= step:
                step = requests[at].step
            self._advance(step)
            frames.match(self._simulation.snapshot)
            while at < len(requests) and requests[at].step == step:
                self._carry_out(requests[at])
                frames.match(self._simulation.snapshot)
                at += 1
            frames.require_matched(self._simulation.snapshot)
            self._when_compared(frames.done, len(self._recording))

    def _advance(self, step: int) -> None:
        """Let the ticks before ``step`` pass; none do after a fault, until a reset."""
        loop = self._simulation.loop
        left = step - loop.steps
        if left <= 0:
            return
        try:
            loop.run(left * loop.control_period)
        except Exception as fault:  # of the physics or a controller
            if loop.steps < step:
                raise DivergedError(
                    Divergence(
                        time=loop.time,
                        what="simulation",
                        recorded="runs on",
                        found=f"stands still: {fault}",
                    )
                ) from None

    def _carry_out(self, recorded: RecordedRequest) -> None:
        request = self._request(recorded)
        if request is None or isinstance(request, _ABOUT_TIME):
            return
        self._n_requests += 1
        error = None
        try:
            answer(self._simulation, request)
        except Tool0Error as failure:
            error = str(failure)
        if (error is None) != (recorded.error is None):
            raise DivergedError(
                Divergence(
                    time=recorded.time,
                    what=f"outcome of {recorded.method}",
                    recorded=recorded.error or "carried out",
                    found=error or "carried out",
                )
            )

    def _request(self, recorded: RecordedRequest) -> Request[Any] | None:
        """Return a request; None, with a reason, if it cannot be repeated."""
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
            self._reasons.append(
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


def _reasons(recording: RecordingFile) -> Iterator[str]:
    """Yield why a repetition may differ."""
    start, requests = recording.bringup, recording.requests
    if not is_deterministic(start.engine):
        yield f"the engine {start.engine} is not deterministic"
    for name, here in current_versions(start.engine).items():
        there = start.versions.get(name, "an unknown version")
        if there != here:
            yield f"recorded with {name} {there}, and this is {here}"
    if start.platform != (here := current_platform()):
        yield f"recorded on {start.platform}, and this is {here}"
    if [item.number for item in requests] != list(range(len(requests))):
        yield (
            "the session was so long that its first requests were dropped: the file "
            "has not all of them"
        )
    if not recording.is_complete:
        yield "the file was cut off: it may lack the last requests"
