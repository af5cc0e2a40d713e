"""External wrenches on links and objects for a limited simulated time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

from tool0.description.scene_state import Contact
from tool0.description.transform import Vector3
from tool0.hardware.engine import World, Wrench

_ZERO: Wrench = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
_ROUNDING = 1e-9
"""Tolerance for differences between a time and a multiple of the tick [s]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class AppliedWrench:
    """Constant force and torque on a body, in the axes of the robot's root frame."""

    name: str
    """Name of the link or object on which the wrench acts."""
    force: Vector3
    """Force [N], in the axes of the robot's root frame."""
    torque: Vector3
    """Torque [N·m], in the axes of the robot's root frame."""
    point: Vector3 | None = None
    """Point where the force is applied when the wrench starts, in the robot's root
    frame [m]; None for the body's center of mass.  The lever arm moves with the body
    but does not rotate."""
    start: float = 0.0
    """Simulated time at which the wrench begins [s].  If the start time has passed, the
    wrench begins immediately."""
    duration: float = math.inf
    """Duration of the wrench [s]."""


@final
class AppliedWrenches:
    """Starts and ends wrenches.

    Only the thread that executes the tick may use ``AppliedWrenches``.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._waiting: tuple[AppliedWrench, ...] = ()
        self._acting: tuple[tuple[float, str, Wrench], ...] = ()
        """End time [s], body, and wrench at the body's center of mass, for each active
        wrench."""

    @property
    def is_idle(self) -> bool:
        """Whether no wrench is active or scheduled."""
        return not self._waiting and not self._acting

    def add(self, wrench: AppliedWrench) -> None:
        """Apply a wrench at its start time, or in the next tick if that is later.

        Raises:
            EngineError: If the link or object does not exist or cannot move.
        """
        self.check(wrench.name)
        self._waiting = (*self._waiting, wrench)

    def check(self, name: str) -> None:
        """Raise EngineError if the link or object does not exist or cannot move."""
        self._world.center_of_mass(name)

    def clear(self, name: str | None = None) -> None:
        """End the wrenches on one link or object, or all wrenches."""
        self._waiting = tuple(w for w in self._waiting if name not in (None, w.name))
        left = tuple(item for item in self._acting if name not in (None, item[1]))
        if left != self._acting:
            self._hold(left)

    def forget(self) -> None:
        """Discard all wrenches after a reset of the engine."""
        self._waiting = self._acting = ()

    def tick(self, time: float) -> None:
        """Start and end wrenches according to ``time`` [s], before a physics step."""
        if self.is_idle:
            return
        now = time + _ROUNDING
        due = [wrench for wrench in self._waiting if wrench.start <= now]
        acting = [item for item in self._acting if item[0] > now]
        if due or len(acting) < len(self._acting):
            self._waiting = tuple(w for w in self._waiting if w.start > now)
            acting += [
                (time + wrench.duration, wrench.name, self._at_center(wrench))
                for wrench in due
            ]
            self._hold(tuple(acting))

    def quiet_ticks(self, time: float, period: float, most: int) -> int:
        """Return the number of upcoming ticks that neither start nor end a wrench.

        The result is at most ``most``, and may be too small by one.  The next tick is
        at ``time`` [s], and each tick takes ``period`` [s].
        """
        changes = [wrench.start for wrench in self._waiting]
        changes += [end for end, _, _ in self._acting]
        quiet = (min(changes, default=math.inf) - _ROUNDING - time) / period
        return most if quiet >= most else max(0, math.floor(quiet))

    def contacts(self) -> tuple[Contact, ...]:
        """Return the active wrenches as contacts, since sensors use contacts."""
        return tuple(
            Contact("", name, self._world.center_of_mass(name), *wrench)
            for _, name, wrench in self._acting
        )

    def _at_center(self, wrench: AppliedWrench) -> Wrench:
        if wrench.point is None:
            return wrench.force, wrench.torque
        center = self._world.center_of_mass(wrench.name)
        rx, ry, rz = (p - c for p, c in zip(wrench.point, center, strict=True))
        (fx, fy, fz), (tx, ty, tz) = wrench.force, wrench.torque
        lever = (ry * fz - rz * fy, rz * fx - rx * fz, rx * fy - ry * fx)
        return wrench.force, (tx + lever[0], ty + lever[1], tz + lever[2])

    def _hold(self, acting: tuple[tuple[float, str, Wrench], ...]) -> None:
        sums: dict[str, Wrench] = {}
        for _, name, (force, torque) in acting:
            before = sums.get(name, _ZERO)
            sums[name] = _sum(before[0], force), _sum(before[1], torque)
        self._world.hold_wrenches(sums)
        self._acting = acting


def _sum(first: Vector3, second: Vector3) -> Vector3:
    x, y, z = (a + b for a, b in zip(first, second, strict=True))
    return x, y, z
