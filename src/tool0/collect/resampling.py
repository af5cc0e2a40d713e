"""Resampling of a recording's snapshots to frames at any rate."""

from __future__ import annotations

from typing import final

import numpy as np
from numpy.typing import NDArray

from tool0.errors import CollectError, ConfigError

Numbers = NDArray[np.float64]


@final
class Resampled:
    """Times at a constant interval, and values of a recording at these times."""

    def __init__(
        self, tick: NDArray[np.int64], period: float, rate: float, name: str
    ) -> None:
        """Choose the times up to the first gap in the snapshots.

        The first time is the time of the first snapshot with a tick that is a multiple
        of the snapshots' interval.  Therefore, each time is the time of a snapshot if
        the interval between the times is a multiple of the snapshots' interval.

        Args:
            tick: Tick of each snapshot [control periods], shape (n,).
            period: Period of the control loop [s].
            rate: Number of times per simulated second [Hz].
            name: Name of the recording in error messages.

        Raises:
            ConfigError: If ``rate`` is higher than the snapshots' rate, or is not a
                number > 0.
            CollectError: If the recording is too short to contain two times.
        """
        if not (np.isfinite(rate) and rate > 0.0):
            raise ConfigError(f"rate must be above 0 Hz, got {rate:g}")
        ticks, self._rows = np.unique(tick, return_index=True)
        steps = np.diff(ticks)
        interval = 1.0 / (rate * period)
        """Interval between two times [ticks]."""
        usual = int(np.median(steps)) if len(steps) else 1
        if interval < usual * (1.0 - 1e-9):
            raise ConfigError(
                f"rate {rate:g} Hz: {name} has {1.0 / (usual * period):g} snapshots "
                "per second; give at most that"
            )
        regular = np.flatnonzero(ticks % usual == 0)
        first = int(regular[0]) if len(regular) else 0
        gaps = np.flatnonzero(steps[first:] > max(interval, usual) * (1.0 + 1e-9))
        last = first + int(gaps[0]) if len(gaps) else len(ticks) - 1
        span = (ticks[last] - ticks[first]) / interval if len(ticks) else -1.0
        count = int(np.floor(span * (1.0 + 1e-12) + 1e-9)) + 1
        if count < 2:
            raise CollectError(
                f"{name} has no two frames {1.0 / rate:g} s apart: it is too short"
            )
        at = ticks[first] + np.arange(count) * interval
        whole = np.rint(at)
        self._ticks = ticks
        self._at = np.where(np.abs(at - whole) < 1e-6, whole, at)

    @property
    def nearest(self) -> NDArray[np.intp]:
        """Index of the snapshot nearest to each time, shape (n_times,)."""
        after = np.searchsorted(self._ticks, self._at).clip(1, len(self._ticks) - 1)
        is_before = self._at - self._ticks[after - 1] <= self._ticks[after] - self._at
        return np.asarray(self._rows[after - is_before.astype(np.intp)])

    def between(self, values: Numbers) -> Numbers:
        """Return values at each time, interpolated linearly between snapshots.

        Args:
            values: Values of each snapshot, shape (n, m).  Interpolation between NaN
                and a number gives NaN.
        """
        return self._interpolated(values[self._rows])

    def poses_between(self, poses: Numbers) -> Numbers:
        """Return the poses (x, y, z, qw, qx, qy, qz) at each time from poses (n, 7)."""
        rows = poses[self._rows]
        turns = rows[:, 3:]
        is_flipped = (turns[1:] * turns[:-1]).sum(axis=1) < 0.0  # q and -q are equal
        signs = np.cumprod(np.concatenate([[1.0], np.where(is_flipped, -1.0, 1.0)]))
        rows = np.hstack([rows[:, :3], turns * signs[:, None]])
        found = self._interpolated(rows)
        found[:, 3:] /= np.linalg.norm(found[:, 3:], axis=1, keepdims=True)
        return found

    def _interpolated(self, rows: Numbers) -> Numbers:
        columns = [np.interp(self._at, self._ticks, column) for column in rows.T]
        return np.stack(columns, axis=1)
