"""Re-simulation of a recording, with the same robot, requests and steps.

A simulation is deterministic between requests, so every frame must be bit-identical to
the recorded frame.  The result lists all reasons for a difference that can be detected.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import final

from tool0.errors import RecordingError
from tool0.recording.comparison import DivergedError, Divergence, Frames
from tool0.recording.entries import RecordedRequest
from tool0.recording.reading import RecordingFile, open_recording
from tool0.recording.repetition import Repetition
from tool0.simulation.handlers.reproduction import restarted
from tool0.simulation.provenance import (
    current_platform,
    current_versions,
    is_deterministic,
)
from tool0.simulation.simulation import Simulation


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Resimulation:
    """Outcome of repeating a recording."""

    frames: int
    """Number of frames that were bit-identical."""
    total_frames: int
    """Number of frames in the recording."""
    requests: int
    """Number of requests that were executed again."""
    divergence: Divergence | None
    """The first difference; None if there is no difference."""
    reasons: tuple[str, ...]
    """Possible reasons why the repetition differs from the recording."""

    @property
    def is_identical(self) -> bool:
        """Whether every frame was bit-identical."""
        return self.divergence is None and self.frames == self.total_frames


def resimulate(
    recording: RecordingFile | Path | str,
    when_compared: Callable[[int, int], None] = lambda done, total: None,
) -> Resimulation:
    """Repeat a recording, compare every frame, and stop at the first difference.

    The time, the position, velocity and effort of every joint, and the poses of the
    objects are compared.

    Args:
        recording: One file, which is repeated from its first frame to its last.
        when_compared: Callback that is called regularly with the number of compared
            frames and the total number of frames.

    Raises:
        RecordingError: If the file is not a recording, or does not contain the data
            that is needed to repeat it.
        Tool0Error: If the robot cannot be brought up, for example because its engine is
            not installed.
    """
    if not isinstance(recording, RecordingFile):
        recording = open_recording(recording)
    if not len(recording):
        raise RecordingError(f"{recording.path} has no snapshot to compare")
    with tempfile.TemporaryDirectory(prefix="tool0-again-") as folder:
        meshes = recording.robot.mesh_files
        simulation = restarted(recording.bringup, Path(folder), meshes)
        try:
            comparison = _Comparison(recording, simulation, meshes, when_compared)
            return comparison.run()
        finally:
            simulation.close()


@final
class _Comparison:
    """One repetition of frames and requests in the order of their steps."""

    def __init__(
        self,
        recording: RecordingFile,
        simulation: Simulation,
        meshes: Mapping[str, Path],
        when_compared: Callable[[int, int], None],
    ) -> None:
        self._recording = recording
        self._simulation = simulation
        self._when_compared = when_compared
        self._frames = Frames(recording)
        self._repetition = Repetition(simulation, meshes)

    def run(self) -> Resimulation:
        divergence = None
        try:
            self._compare()
        except DivergedError as diverged:
            divergence = diverged.divergence
        repetition = self._repetition
        return Resimulation(
            frames=self._frames.done,
            total_frames=len(self._recording),
            requests=repetition.n_requests,
            divergence=divergence,
            reasons=(*_reasons(self._recording), *repetition.notes),
        )

    def _compare(self) -> None:
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
        try:
            self._repetition.advance(step)
        except Exception as fault:  # raised by the physics or a controller
            raise DivergedError(
                Divergence(
                    time=self._simulation.loop.time,
                    what="simulation",
                    recorded="runs on",
                    found=f"stands still: {fault}",
                )
            ) from None

    def _carry_out(self, recorded: RecordedRequest) -> None:
        error = self._repetition.repeat(recorded)
        if (error is None) != (recorded.error is None):
            raise DivergedError(
                Divergence(
                    time=recorded.time,
                    what=f"outcome of {recorded.method}",
                    recorded=recorded.error or "carried out",
                    found=error or "carried out",
                )
            )


def _reasons(recording: RecordingFile) -> Iterator[str]:
    """Yield reasons why a repetition may differ from the recording."""
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
