"""Speed profiles along a path, with phases of constant acceleration."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from tool0.kinematics.chain import Array

_NOTHING = 1e-12
_COPIES = 8
"""Number of delayed copies that are averaged for a smoothed profile."""


class Phase(NamedTuple):
    """A phase of constant acceleration."""

    duration: float
    """Duration of the phase [s]."""
    acceleration: float
    """Acceleration during the phase [m/s² | rad/s²]."""


@final
class SpeedProfile:
    """The distance x along a path as a non-decreasing function of time.

    Distances are in meters or radians, as they are on the path.
    """

    def __init__(
        self, phases: Sequence[Phase], before: float, after: float, length: float
    ) -> None:
        """Use phases over ``length`` from speed ``before`` to speed ``after``."""
        lasting = [phase for phase in phases if phase.duration > _NOTHING]
        times, distances, speeds = [0.0], [0.0], [before]
        for duration, acceleration in lasting:
            times.append(times[-1] + duration)
            speeds.append(max(speeds[-1] + acceleration * duration, 0.0))
            distances.append(distances[-1] + duration * sum(speeds[-2:]) / 2.0)
        if lasting:  # avoid rounding errors of the sums
            distances[-1], speeds[-1] = length, after
        self.times = np.array(times)
        """Times at which phases start or end, from 0 to the duration [s]."""
        self.distances = np.array(distances)
        """Distances x at ``times``."""
        self.speeds = np.array(speeds)
        """Speeds at ``times`` [1/s]."""
        self._accelerations = np.array([a for _, a in lasting] or [0.0])
        self.duration = times[-1]
        """Duration of the complete profile [s]."""

    @classmethod
    def steady(cls, duration: float) -> SpeedProfile:
        """Return the profile in which x equals the time."""
        return cls([Phase(duration, 0.0)], 1.0, 1.0, duration)

    @property
    def peak(self) -> float:
        """Maximum speed of the profile."""
        return float(self.speeds.max())

    def at(self, times: Array) -> Array:
        """Return x, speed and acceleration at times in the profile, shape (n, 3)."""
        last = len(self._accelerations) - 1
        k = np.clip(np.searchsorted(self.times, times, side="right") - 1, 0, last)
        t, a, v = times - self.times[k], self._accelerations[k], self.speeds[k]
        x = np.minimum(self.distances[k] + t * (v + a * t / 2.0), self.distances[-1])
        return np.stack([x, np.maximum(v + a * t, 0.0), a], axis=1)

    def speed_at(self, distances: Array) -> Array:
        """Return the speed at each distance x, shape (n,)."""
        k, beyond = self._phase(distances)
        square = self.speeds[k] ** 2 + 2.0 * self._accelerations[k] * beyond
        return np.asarray(np.sqrt(np.maximum(square, 0.0)))

    def times_at(self, distances: Array) -> Array:
        """Return the time at which each distance x is reached [s], shape (n,)."""
        k, beyond = self._phase(distances)
        mean = (self.speeds[k] + self.speed_at(distances)) / 2.0
        with np.errstate(invalid="ignore", divide="ignore"):
            t = np.where(beyond > 0.0, beyond / mean, 0.0)
        return np.asarray(np.minimum(self.times[k] + t, self.times[-1]))

    def _phase(self, distances: Array) -> tuple[NDArray[np.intp], Array]:
        """Return the phase at each x, and the distance from the start of the phase."""
        phases = np.searchsorted(self.distances, distances, side="right") - 1
        k = np.clip(phases, 0, len(self._accelerations) - 1)
        return k, np.maximum(distances - self.distances[k], 0.0)


def trapezoid(
    length: float,
    speed: float,
    acceleration: float,
    before: float = 0.0,
    after: float = 0.0,
) -> SpeedProfile:
    """Return the fastest profile over ``length`` within ``speed`` and ``acceleration``.

    The profile starts with the speed ``before`` and ends with the speed ``after``,
    which must be reachable: |after² - before²| <= 2 acceleration length. A short
    profile is a triangle.
    """
    top = math.sqrt(acceleration * length + (before**2 + after**2) / 2.0)
    top = max(min(speed, top), before, after)
    ramps = (2.0 * top**2 - before**2 - after**2) / (2.0 * acceleration)
    steady = (length - ramps) / top if top > 0.0 else 0.0
    return SpeedProfile(
        [
            Phase((top - before) / acceleration, acceleration),
            Phase(steady, 0.0),
            Phase((top - after) / acceleration, -acceleration),
        ],
        before,
        after,
        length,
    )


def braking(length: float, speed: float, acceleration: float) -> SpeedProfile:
    """Return the profile that decelerates from ``speed`` to rest over ``length``.

    The deceleration starts as late as ``acceleration`` allows. If ``acceleration`` is
    too low for ``length``, the deceleration is higher.
    """
    if speed <= 0.0:
        return trapezoid(length, math.sqrt(acceleration * length), acceleration)
    return trapezoid(length, speed, max(acceleration, speed**2 / (2.0 * length)), speed)


def ramp(length: float, before: float, after: float) -> SpeedProfile:
    """Return the profile with constant acceleration between two speeds."""
    duration = 2.0 * length / (before + after)
    phase = Phase(duration, (after - before) / duration)
    return SpeedProfile([phase], before, after, length)


def smoothed(profile: SpeedProfile, duration: float) -> SpeedProfile:
    """Return a profile from rest to rest without sudden changes of acceleration.

    The result is the mean of copies that are delayed by 0 … ``duration`` [s]. The
    smoothed profile takes ``duration`` longer. The speed is not higher than in the
    original profile, and the acceleration changes in small steps.
    """
    delays = np.linspace(0.0, duration, _COPIES)
    times = np.sort((profile.times + delays[:, None]).ravel())
    middles = (times[1:] + times[:-1]) / 2.0 - delays[:, None]
    moves = (middles > 0.0) & (middles < profile.duration)
    accelerations = np.zeros_like(middles)
    accelerations[moves] = profile.at(middles[moves])[:, 2]
    phases = zip(
        np.diff(times).tolist(), accelerations.mean(axis=0).tolist(), strict=True
    )
    length = float(profile.distances[-1])
    return SpeedProfile([Phase(*phase) for phase in phases], 0.0, 0.0, length)
