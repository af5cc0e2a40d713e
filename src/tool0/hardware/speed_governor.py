"""Keeps joints within their speeds, as the drives of a real arm do.

The joints of an arm fling each other: what one drive does changes the speeds of all.
The governor predicts the velocities after the coming step, from the accelerations in
the last one and from the changes of all efforts.  If one exceeds its limit, each drive
chooses the effort closest to the requested one with which its joint does not (projected
Gauss-Seidel); if that is too weak, all drives help.  The governor knows the masses of
the description only: a load slows the joints down, and the governor, too.  (With those
of a declared payload, it would fling joints that do not carry it.)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple, final

FAST: Final = 0.5
"""Part of its largest speed from which a joint is governed: below it, no drive but that
of a light joint reaches its largest speed within a step of 1 ms."""
SWEEPS: Final = 20
"""Most sweeps over all joints."""
TOLERANCE: Final = 1e-6
"""Excess of speed that ends the sweeps [rad/s | m/s]."""
LARGEST_TURN: Final = 0.25
"""Motion of a joint for which a mobility is used [rad | m]."""


class GovernedDrive(NamedTuple):
    """The constants of a governed joint."""

    joint: int
    speed: float
    """Largest speed [rad/s | m/s]."""
    fast: float
    """Speed from which the joint is governed [rad/s | m/s]."""
    effort: float
    """Largest effort of its drive [N·m | N]."""


class GovernorSetup(NamedTuple):
    """Data that change with claims and brakes, and while a joint is fast."""

    drives: tuple[GovernedDrive, ...] = ()
    free: tuple[int, ...] = ()
    """The joints that no brake holds, the governed ones first."""
    mobility: tuple[tuple[float, ...], ...] = ()
    """Change of the velocities of the free joints in a step, by row, for the efforts of
    each [rad/s/(N·m)]; empty if it is to be computed."""
    posture: tuple[float, ...] = ()
    """Positions of the free joints at which it was computed [rad | m]."""


class GovernorState(NamedTuple):
    """Data that change in each step."""

    before: Sequence[float] = ()
    """Velocity of each joint in the last step [rad/s | m/s]; empty before the first."""


@final
class SpeedGovernor:
    """Limits the efforts of some joints in each step."""

    def __init__(self) -> None:
        self.setup, self.state = GovernorSetup(), GovernorState()

    @property
    def setup(self) -> GovernorSetup:
        """Data that change with claims and brakes, and while a joint is fast."""
        return self._setup

    @setup.setter
    def setup(self, setup: GovernorSetup) -> None:
        self._setup = setup
        self._fast = [(drive.joint, drive.fast) for drive in setup.drives]

    def choose(self, drives: Sequence[GovernedDrive], free: Sequence[int]) -> None:
        """Govern these drives from now on; brakes hold all joints but the ``free``."""
        governed = [drive.joint for drive in drives]
        others = [joint for joint in free if joint not in governed]
        self.setup = GovernorSetup(tuple(drives), (*governed, *others))
        self.state = GovernorState()

    def is_fast(self, velocity: Sequence[float]) -> bool:
        """Return whether ``limit`` has something to look at."""
        for joint, fast in self._fast:  # noqa: SIM110 - in the tick, twice as fast
            if abs(velocity[joint]) > fast:
                return True
        return False

    def is_mobility_due(self, position: Sequence[float]) -> bool:
        """Return whether ``limit`` needs the mobility at other positions."""
        _, free, mobility, posture = self._setup
        return not mobility or any(
            abs(position[i] - q) > LARGEST_TURN
            for i, q in zip(free, posture, strict=True)
        )

    def update(
        self, mobility: Sequence[Sequence[float]], position: Sequence[float]
    ) -> None:
        """Use a mobility of the free joints, computed at these positions of all."""
        posture = tuple(position[i] for i in self.setup.free)
        rows = tuple(map(tuple, mobility))
        self.setup = self.setup._replace(mobility=rows, posture=posture)

    def note(self, velocity: Sequence[float]) -> None:
        """Remember the velocities of a step."""
        self.state = GovernorState(velocity)

    def limit(
        self, effort: list[float], applied: Sequence[float], velocity: Sequence[float]
    ) -> None:
        """Limit ``effort`` in place; ``applied`` is that of the last step [N·m | N]."""
        before = self.state.before
        if not before:
            return
        drives, free, mobility, _ = self.setup
        coming = [velocity[i] + (velocity[i] - before[i]) for i in free]
        wanted = [effort[i] for i in free]
        for k, drive in enumerate(drives):
            wanted[k] = min(max(wanted[k], -drive.effort), drive.effort)
        for row, u, i in zip(mobility, wanted, free, strict=True):
            _change(coming, row, u - applied[i])
        if all(abs(coming[k]) <= drive.speed for k, drive in enumerate(drives)):
            return
        used = wanted.copy()
        for _ in range(SWEEPS):
            has_changed = False
            for k, drive in enumerate(drives):
                row, old = mobility[k], used[k]
                reached = coming[k] + row[k] * (wanted[k] - old)
                reached = min(max(reached, -drive.speed), drive.speed)
                best = old + (reached - coming[k]) / row[k]
                used[k] = best = min(max(best, -drive.effort), drive.effort)
                if best != old:
                    has_changed = True
                    _change(coming, row, best - old)
            if not has_changed:
                break
        self._share_excess(coming, used)
        for k, drive in enumerate(drives):
            effort[drive.joint] = used[k]

    def _share_excess(self, coming: list[float], used: list[float]) -> None:
        """Share what a joint's own drive cannot brake among all drives.

        Each by its effect on that joint (Kaczmarz's method).
        """
        drives, _, mobility, _ = self.setup
        for _ in range(SWEEPS):
            is_within = True
            for k, slowed in enumerate(drives):
                bound = min(max(coming[k], -slowed.speed), slowed.speed)
                excess = coming[k] - bound
                if not abs(excess) > TOLERANCE:
                    continue
                is_within = False
                norm = 0.0
                for j in range(len(drives)):
                    norm += mobility[k][j] * mobility[k][j]
                for j, drive in enumerate(drives):
                    old = used[j]
                    best = old - excess * mobility[k][j] / norm
                    used[j] = best = min(max(best, -drive.effort), drive.effort)
                    _change(coming, mobility[j], best - old)
            if is_within:
                break


def _change(coming: list[float], row: Sequence[float], by: float) -> None:
    """Add the effect of a change of one effort to the coming velocities."""
    for j, gain in enumerate(row):
        coming[j] += gain * by
