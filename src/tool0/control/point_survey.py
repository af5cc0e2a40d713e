"""What is known of many points before they are wanted, worked out by numpy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

from tool0.control.segment import IMPLAUSIBLE

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from tool0.control.trajectory import TrajectoryPoint

    Numbers = NDArray[np.float64]

MANY = 50
"""From so many points on a survey is quicker than what it saves the tick, and pieces
are made when they are played; below, it is quicker to look at every point at once."""

BLOCK = 1024
"""Points that are surveyed in one go: less than a millisecond, during which no other
thread runs."""

SHORT = 1e-9
"""Segments that are shorter than this [s] are looked at one by one: rounding rules."""

_TERMS = 256.0
"""``Segment.is_bounded`` sums up at most 32 |d| + 32 |v| T + 6 |a| T² on top of the
position, and 120 |d| + 121 |v| T + 22 |a| T² for T times the speed, where d is the way
and v and a are the larger ones of both ends.  Twice that leaves room for rounding."""


@final
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PointSurvey:
    """Where to look at many points; where not to, since all is well.

    It is made in the thread that asks, so that the tick need not read every number.
    """

    n_joints: int
    """Of the first point."""
    n_timed: int
    """So many points from the first on have finite times that increase."""
    n_sound: int
    """So many have finite numbers, as many of each kind as there are joints."""
    times: Numbers
    """After the start [s], shape (n_points,)."""
    lowest: Numbers
    """Smallest positions [rad | m], shape (n_blocks, n_joints); NaN if unsound."""
    highest: Numbers
    """Largest positions [rad | m], shape (n_blocks, n_joints); NaN if unsound."""
    extremes: Numbers
    """Largest position, change of position, velocity and acceleration of any joint from
    one point to the next, shape (4, n_points - 1); inf if unsound."""

    def beyond(
        self, ranges: Sequence[tuple[float, float]], n_ahead: int
    ) -> Iterator[int]:
        """Yield the numbers of those that may be out of the joints' ranges.

        Only the last ``n_ahead`` points are meant, and counted.
        """
        import numpy as np

        lower, upper = zip(*ranges, strict=True)
        good = ((self.lowest >= lower) & (self.highest <= upper)).all(axis=1)
        dropped = len(self.times) - n_ahead
        for block in np.flatnonzero(~good).tolist():
            first = block * BLOCK - dropped
            yield from range(max(first, 0), min(first + BLOCK, n_ahead))

    def schedule(
        self, start: float, n_ahead: int, shift: float
    ) -> tuple[list[float], list[int]]:
        """Return the times [s] of the last points, and which may be implausible.

        Args:
            start: When the trajectory starts [s].
            n_ahead: How many points are meant, and counted.
            shift: How far their positions are moved at most [rad].

        The way to the first of them is not known here.
        """
        import numpy as np

        with np.errstate(all="ignore"):
            times = start + self.times[-n_ahead:]
            T = np.diff(times)
            place, way, v, a = self.extremes[:, len(self.times) - n_ahead :]
            terms = _TERMS * (way + T * (v + T * a))
            good = (place + shift + terms <= IMPLAUSIBLE) & (terms <= IMPLAUSIBLE * T)
            suspects = np.flatnonzero(~(good & (T >= SHORT))) + 1
        return times.tolist(), suspects.tolist()


def survey(points: Sequence[TrajectoryPoint]) -> PointSurvey:
    """Return what is known of the points; at least one."""
    import numpy as np

    n_joints = len(points[0].positions)
    n_blocks = -(-len(points) // BLOCK)
    times = np.array([point.time_from_start for point in points])
    lowest = np.full((n_blocks, n_joints), np.nan)
    highest = lowest.copy()
    extremes = np.full((4, len(points) - 1), np.inf)
    with np.errstate(all="ignore"):
        ordered = np.isfinite(times) & (np.diff(times, prepend=-np.inf) > 0.0)
        n_sound = 0
        for block in range(n_blocks if n_joints else 0):
            first = block * BLOCK
            # One more, since the way to the next block's first point counts as well.
            numbers = _numbers(points[first : first + BLOCK + 1], n_joints)
            if numbers is None:
                break
            n_sound = min(first + BLOCK, len(points))
            lowest[block] = numbers[0, :BLOCK].min(axis=0)
            highest[block] = numbers[0, :BLOCK].max(axis=0)
            ways = np.abs(np.diff(numbers[0], axis=0)).max(axis=1)
            place, v, a = np.abs(numbers).max(axis=2)
            for row, values in zip(extremes, (place, None, v, a), strict=True):
                row[first : first + BLOCK] = (
                    ways if values is None else np.maximum(values[:-1], values[1:])
                )
    return PointSurvey(
        n_joints=n_joints,
        n_timed=len(points) if ordered.all() else int(ordered.argmin()),
        n_sound=n_sound,
        times=times,
        lowest=lowest,
        highest=highest,
        extremes=extremes,
    )


def _numbers(points: Sequence[TrajectoryPoint], n_joints: int) -> Numbers | None:
    """Return positions, velocities and accelerations, or None if unsound.

    What is not prescribed is 0.  Shape (3, n_points, n_joints).
    """
    import numpy as np

    absent = (0.0,) * n_joints
    try:
        numbers = np.array(
            [
                [point.positions for point in points],
                [point.velocities or absent for point in points],
                [point.accelerations or absent for point in points],
            ],
            dtype=np.float64,
        )
    except ValueError:  # not as many numbers everywhere
        return None
    # The same wrong number of positions everywhere is no error of numpy's.
    sound = numbers.shape == (3, len(points), n_joints) and np.isfinite(numbers).all()
    return numbers if sound else None
