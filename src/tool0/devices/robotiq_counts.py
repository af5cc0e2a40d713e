"""Conversions between a gripper's quantities and its register counts."""

from __future__ import annotations

from typing import Final, final

from tool0.description.model import LinearOpening, ParallelGripper

FULL: Final = 255
TOP_CURRENT: Final = 1.0
"""Motor current at the maximum grip force [A], which is the peak value in the 2F-85's
data sheet."""


@final
class Counts:
    """Converts between the quantities and the register counts of a gripper.

    The encoder is on the motor, so the position count is linear in the position of the
    driven joint. Grippers with swinging fingers report 3 when fully open and 230 when
    fully closed (as measured by Robotiq; see device_profile.hpp in Robotiq's SDK). The
    fingers of a Hand-E slide, and a Hand-E uses the full range of counts. Speed and
    force are linear in their counts.
    """

    def __init__(self, geometry: ParallelGripper) -> None:
        self.geometry = geometry
        slides = isinstance(geometry.law, LinearOpening)
        self.open, self.closed = (0, FULL) if slides else (3, 230)
        self._open_at = geometry.position(geometry.max_opening)
        self._closed_at = geometry.position(0.0)

    def count(self, position: float) -> int:
        """Return the count for a joint position between open and closed [rad | m]."""
        part = (position - self._open_at) / (self._closed_at - self._open_at)
        count = round(self.open + part * (self.closed - self.open))
        return min(max(count, self.open), self.closed)

    def opening(self, count: int) -> float:
        """Return the opening for a count, clipped to the gripper's range [m]."""
        part = (count - self.open) / (self.closed - self.open)
        part = min(max(part, 0.0), 1.0)
        position = self._open_at + part * (self._closed_at - self._open_at)
        opening = self.geometry.opening(position)
        return min(max(opening, 0.0), self.geometry.max_opening)

    def speed(self, count: int) -> float:
        """Return the speed of the pads for a speed count [m/s]."""
        return _between(self.geometry.speed, count)

    def force(self, count: int) -> float:
        """Return the force at each pad for a force count [N]."""
        return _between(self.geometry.force, count)

    def current(self, position: float, effort: float) -> int:
        """Return the motor current [10 mA] for an effort of the driven joint [N·m | N].

        The current is assumed to be proportional to the force at the pads.
        """
        force = abs(effort) / self.geometry.lever(position)
        return _byte(100.0 * TOP_CURRENT * force / self.geometry.force[1])


def _between(span: tuple[float, float], count: int) -> float:
    low, high = span
    return low + (high - low) * count / FULL


def _byte(value: float) -> int:
    return min(max(round(value), 0), FULL)
