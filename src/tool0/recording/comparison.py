"""Bit-by-bit comparison of a repeated simulation with the frames of its recording."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, final

import numpy as np

from tool0.protocol.state import Snapshot

if TYPE_CHECKING:
    from tool0.recording.reading import RecordingFile

_POSE: Final = ("x", "y", "z", "qw", "qx", "qy", "qz")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Divergence:
    """The first difference between the repetition and the recording."""

    time: float
    """Simulated time [s]."""
    what: str
    """Name of the quantity, such as ``position of elbow_joint``."""
    recorded: float | str
    """Recorded value [rad | m], [rad/s | m/s], [N·m | N] or [m]; for the outcome of a
    request, the value is text."""
    found: float | str
    """Value in the repetition."""

    def __str__(self) -> str:
        return (
            f"at {self.time:.3f} s, {self.what}: recorded {self.recorded!r}, "
            f"now {self.found!r}"
        )


@final
class DivergedError(Exception):
    """Raised if the repetition differs from the recording."""

    def __init__(self, divergence: Divergence) -> None:
        super().__init__(str(divergence))
        self.divergence = divergence


@final
class Frames:
    """The recorded frames, and the number of frames that were reproduced."""

    def __init__(self, recording: RecordingFile) -> None:
        self.done = 0
        self._names = recording.joint_names
        self._steps: list[int] = recording.step.tolist()
        self._times: list[float] = recording.time.tolist()
        self._states = np.hstack(
            [recording.position, recording.velocity, recording.effort]
        )
        self._objects = recording.objects

    @property
    def is_done(self) -> bool:
        return self.done == len(self._steps)

    @property
    def next_step(self) -> int:
        """The step of the next frame to compare."""
        return self._steps[self.done]

    def match(self, snapshot: Snapshot) -> None:
        """Mark the next frames that equal this state as reproduced."""
        while not self.is_done and self.next_step == snapshot.step:
            if next(self._differences(snapshot), None) is not None:
                return
            self.done += 1

    def require_matched(self, snapshot: Snapshot) -> None:
        """Raise DivergedError if a frame of this step was not reproduced."""
        if not self.is_done and self.next_step <= snapshot.step:
            raise DivergedError(next(self._differences(snapshot)))

    def _differences(self, snapshot: Snapshot) -> Iterator[Divergence]:
        """Yield the differences between the next frame and ``snapshot``."""
        time = self._times[self.done]
        if time != snapshot.time:
            yield _difference(time, "simulated time", time, snapshot.time)
        wanted = self._states[self.done]
        found = np.array((*snapshot.position, *snapshot.velocity, *snapshot.effort))
        if wanted.tobytes() != found.tobytes():
            n = len(self._names)
            for i in np.flatnonzero(wanted.view("i8") != found.view("i8")):
                what = ("position", "velocity", "effort")[i // n]
                name = f"{what} of {self._names[i % n]}"
                yield _difference(time, name, wanted[i], found[i])
        yield from self._object_differences(snapshot, time)

    def _object_differences(
        self, snapshot: Snapshot, time: float
    ) -> Iterator[Divergence]:
        poses = {
            item.name: np.array((*item.position, *item.quat_wxyz))
            for item in snapshot.objects
        }
        for name in {**self._objects, **poses}:
            rows = self._objects.get(name)
            wanted = None if rows is None else rows[self.done]
            if wanted is not None and np.isnan(wanted).all():
                wanted = None
            found = poses.get(name)
            if wanted is None or found is None:
                if (wanted is None) != (found is None):
                    yield Divergence(
                        time=time,
                        what=f"object {name}",
                        recorded="absent" if wanted is None else "present",
                        found="absent" if found is None else "present",
                    )
            elif wanted.tobytes() != found.tobytes():
                i = int(np.flatnonzero(wanted.view("i8") != found.view("i8"))[0])
                what = f"{_POSE[i]} of object {name}"
                yield _difference(time, what, wanted[i], found[i])


def _difference(time: float, what: str, wanted: float, found: float) -> Divergence:
    return Divergence(time=time, what=what, recorded=float(wanted), found=float(found))
