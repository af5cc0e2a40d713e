"""Signals of a recording as arrays, with the names in the panel's plots."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Final, final

import numpy as np

from tool0.description.joint_tree import LinkFrames
from tool0.description.parts import find_arms
from tool0.description.transform_arrays import Array, from_quats, to_rpy
from tool0.errors import RecordingError, did_you_mean

if TYPE_CHECKING:
    from tool0.recording.reading import RecordingFile
    from tool0.recording.simulated_run import SimulatedRun

_POSE: Final = ("x", "y", "z", "roll", "pitch", "yaw")
_WRENCH: Final = ("fx", "fy", "fz", "tx", "ty", "tz")


@final
class Signals(Mapping[str, Array]):
    """Values of signals at each snapshot in SI units, shape (n,); NaN if missing.

    Names have forms such as ``joint/NAME/position``, ``tool/ARM/x``, ``wrench/ARM/fz``,
    ``gripper/NAME/opening`` and ``object/NAME/yaw``.  Each signal is computed when it
    is first read.
    """

    def __init__(
        self, recording: RecordingFile, beside: SimulatedRun | None = None
    ) -> None:
        """Use a recording, and optionally a simulated run for additional signals."""
        self._recording = recording
        self._beside = beside
        self._makers = dict(self._all())
        self._known: dict[str, Array] = {}

    def __getitem__(self, name: str) -> Array:
        """Return the values of a signal, or raise RecordingError."""
        if name not in self._makers:
            hint = did_you_mean(name, list(self._makers))
            raise RecordingError(f"the recording has no signal '{name}'{hint}")
        if name not in self._known:
            self._known[name] = self._makers[name]()
        return self._known[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._makers)

    def __len__(self) -> int:
        """Return the number of signals."""
        return len(self._makers)

    def _all(self) -> Iterator[tuple[str, Callable[[], Array]]]:
        recording = self._recording
        for i, name in enumerate(recording.joint_names):
            for quantity, read in _JOINT.items():
                yield f"joint/{name}/{quantity}", partial(read, recording, i)
            if (run := self._beside) is not None:
                yield f"joint/{name}/simulated", partial(_of, run.position, i)
                yield f"joint/{name}/simulated_effort", partial(_of, run.effort, i)
        for arm, parts in find_arms(recording.description.model).items():
            for i, part in enumerate(_POSE):
                yield f"tool/{arm}/{part}", partial(self._tool, parts.flange, i)
        for arm in recording.wrenches:
            for i, part in enumerate(_WRENCH):
                column = partial(_column, recording.wrenches, arm, i)
                yield f"wrench/{arm}/{part}", column
        for name in recording.gripper_states:
            states = recording.gripper_states
            yield f"gripper/{name}/opening", partial(_column, states, name, 0)
            yield f"gripper/{name}/force", partial(_column, states, name, 2)
        for name in recording.objects:
            for i, part in enumerate(_POSE):
                yield f"object/{name}/{part}", partial(self._object, name, i)

    def _tool(self, link: str, part: int) -> Array:
        recording = self._recording
        given = dict(zip(recording.joint_names, recording.position.T, strict=True))
        frames = LinkFrames(recording.description.model, [link])
        found = frames.poses(given, len(recording.position))[link]
        if part < 3:
            return found.position[:, part]
        return to_rpy(found.rotation)[:, part - 3]

    def _object(self, name: str, part: int) -> Array:
        poses = self._recording.objects[name]
        if part < 3:
            return poses[:, part]
        return to_rpy(from_quats(poses[:, 3:]))[:, part - 3]


_JOINT: Final[Mapping[str, Callable[[RecordingFile, int], Array]]] = {
    "position": lambda recording, i: recording.position[:, i],
    "desired": lambda recording, i: recording.desired_position[:, i],
    "error": lambda recording, i: (
        recording.desired_position[:, i] - recording.position[:, i]
    ),
    "velocity": lambda recording, i: recording.velocity[:, i],
    "effort": lambda recording, i: recording.effort[:, i],
}


def _of(rows: Array, i: int) -> Array:
    return rows[:, i]


def _column(table: Mapping[str, Array], name: str, i: int) -> Array:
    return table[name][:, i]


def thinned(
    time: Array, columns: Sequence[Array], points: int
) -> tuple[list[float], list[list[float | None]]]:
    """Return at most about ``points`` samples of signals, including all peaks.

    In each group of consecutive samples, the smallest and the largest samples are kept
    in their original order.  NaN is replaced by None.
    """
    n = len(time)
    bucket = math.ceil(n / max(1, points // 2))
    if n <= points or bucket < 3:
        return time.tolist(), [_plain(column) for column in columns]
    starts = np.arange(0, n, bucket)
    ends = np.minimum(starts + bucket, n) - 1
    pairs = np.stack([time[starts], time[ends]], axis=1)
    return pairs.ravel().tolist(), [_plain(_extremes(c, bucket)) for c in columns]


def _extremes(column: Array, bucket: int) -> Array:
    n = -(-len(column) // bucket)
    padded = np.full(n * bucket, math.nan)
    padded[: len(column)] = column
    rows = padded.reshape(n, bucket)
    least = np.where(np.isnan(rows), math.inf, rows).argmin(axis=1)
    most = np.where(np.isnan(rows), -math.inf, rows).argmax(axis=1)
    which = np.sort(np.stack([least, most], axis=1), axis=1)
    return np.take_along_axis(rows, which, axis=1).ravel()


def _plain(column: Array) -> list[float | None]:
    return [None if math.isnan(value) else value for value in column.tolist()]
