"""Keeps joints within their speed limits, as the drives of a real arm do.

The effort of one drive affects the speeds of all joints in an arm.  The governor
predicts the velocities after the coming step from the accelerations in the last step
and the changes of all efforts.  If a predicted velocity exceeds its limit, each drive
applies the effort that keeps its joint within the limit and is closest to the requested
effort (projected Gauss-Seidel).  If a drive is too weak to keep its joint within the
limit, all drives contribute.  The governor uses only the masses of the description.
Under a load, both the joints and the governor therefore react more slowly.  Masses that
include a declared payload would let the governor accelerate joints beyond their limits
if the payload were not actually carried.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple, final

FAST: Final = 0.5
"""Fraction of its speed limit above which a joint is governed.  From a lower speed,
only the drive of a light joint could reach the limit within a step of 1 ms."""
SWEEPS: Final = 20
"""Largest number of sweeps over all joints."""
TOLERANCE: Final = 1e-6
"""Excess speed below which the governor performs no more sweeps [rad/s | m/s]."""
LARGEST_TURN: Final = 0.25
"""Motion of a joint after which the mobility is recomputed [rad | m]."""


class GovernedDrive(NamedTuple):
    """The constants of a governed joint."""

    joint: int
    speed: float
    """Largest speed [rad/s | m/s]."""
    fast: float
    """Speed above which the joint is governed [rad/s | m/s]."""
    effort: float
    """Largest effort of the joint's drive [N·m | N]."""


class GovernorSetup(NamedTuple):
    """Data that change when claims or brakes change, and while a joint is fast."""

    drives: tuple[GovernedDrive, ...] = ()
    free: tuple[int, ...] = ()
    """Indices of the joints that no brake holds, with the governed joints first."""
    mobility: tuple[tuple[float, ...], ...] = ()
    """Velocity changes of the free joints in a step, per unit of effort of each free
    joint, by row [rad/s/(N·m)]; empty until they are computed."""
    posture: tuple[float, ...] = ()
    """Positions of the free joints at which ``mobility`` was computed [rad | m]."""


class GovernorState(NamedTuple):
    """Data that change in each step."""

    before: Sequence[float] = ()
    """Velocity of each joint in the last step [rad/s | m/s]; empty before the first
    step."""


@final
class SpeedGovernor:
    """Limits efforts in each step so that joints stay within their speed limits."""

    def __init__(self) -> None:
        self.setup, self.state = GovernorSetup(), GovernorState()

    @property
    def setup(self) -> GovernorSetup:
        """Data that change when claims or brakes change, and while a joint is fast."""
        return self._setup

    @setup.setter
    def setup(self, setup: GovernorSetup) -> None:
        self._setup = setup
        self._fast = [(drive.joint, drive.fast) for drive in setup.drives]

    def choose(self, drives: Sequence[GovernedDrive], free: Sequence[int]) -> None:
        """Govern ``drives``.  Brakes hold all joints that are not in ``free``."""
        governed = [drive.joint for drive in drives]
        others = [joint for joint in free if joint not in governed]
        self.setup = GovernorSetup(tuple(drives), (*governed, *others))
        self.state = GovernorState()

    def is_fast(self, velocity: Sequence[float]) -> bool:
        """Return whether any governed joint is fast, so that ``limit`` is needed."""
        for joint, fast in self._fast:  # noqa: SIM110 - in the tick, twice as fast
            if abs(velocity[joint]) > fast:
                return True
        return False

    def is_mobility_due(self, position: Sequence[float]) -> bool:
        """Return whether ``limit`` needs a mobility for new positions."""
        _, free, mobility, posture = self._setup
        return not mobility or any(
            abs(position[i] - q) > LARGEST_TURN
            for i, q in zip(free, posture, strict=True)
        )

    def update(
        self, mobility: Sequence[Sequence[float]], position: Sequence[float]
    ) -> None:
        """Use ``mobility`` of the free joints, computed at the given positions."""
        posture = tuple(position[i] for i in self.setup.free)
        rows = tuple(map(tuple, mobility))
        self.setup = self.setup._replace(mobility=rows, posture=posture)

    def note(self, velocity: Sequence[float]) -> None:
        """Store the velocities of this step [rad/s | m/s]."""
        self.state = GovernorState(velocity)

    def limit(
        self, effort: list[float], applied: Sequence[float], velocity: Sequence[float]
    ) -> None:
        """Limit ``effort`` in place.  ``applied`` is the previous effort [N·m | N]."""
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
        """Use all drives to reduce excess speed that the joint's drive cannot reduce.

        The contribution of each drive depends on its effect on the joint with the
        excess speed (Kaczmarz's method).
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
    """Add the effect of a change of one effort to the predicted velocities."""
    for j, gain in enumerate(row):
        coming[j] += gain * by
