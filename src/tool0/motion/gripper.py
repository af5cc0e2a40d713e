"""Motion of a gripper's pads between two openings."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tool0.description.model import ParallelGripper
from tool0.motion.path import Path

RAMP_TIME = 1.0 / 15.0
"""Time in which the pads accelerate from rest to full speed or decelerate to rest [s].
The value is a guess, because datasheets do not specify the ramp time. The time prevents
the fingers from overshooting."""
SPACING = 0.005
"""Maximum distance between the knots of a planned motion [m]."""


def opening_path(
    geometry: ParallelGripper, start: float, end: float, speed: float
) -> Path:
    """Return the driven joint's path on which the pads accelerate, cruise and stop.

    The knots are closely spaced, because a linkage converts a constant opening speed to
    a variable joint speed. ``start`` and ``end`` are distances between the pads [m];
    ``end`` must be within 0 … ``geometry.max_opening``. ``speed`` is the relative speed
    of the pads [m/s].
    """
    widest, longest_ramp = geometry.max_opening, geometry.speed[1] * RAMP_TIME / 2.0
    start = min(start, widest)
    distance = abs(end - start)
    ramp = min(longest_ramp, distance / 2.0)
    speed *= math.sqrt(ramp / longest_ramp)  # a short motion does not reach full speed
    n_points = max(2, math.ceil(distance / SPACING))
    times, positions = [0.0], [geometry.position(max(0.0, start))]
    velocities = [0.0]
    for k in range(1, n_points + 1):
        done = distance * k / n_points
        at, rate = _ramped(done, distance, ramp, speed)
        reached = start + math.copysign(done, end - start)
        q = geometry.position(min(max(0.0, reached), widest))  # rounding
        times.append(max(at, 1e-3 * k))
        positions.append(q)
        velocities.append(-math.copysign(rate, end - start) / geometry.lever(q))
    return _path(geometry, times, positions, velocities)


def direct_path(
    geometry: ParallelGripper, start: float, end: float, speed: float, shortest: float
) -> Path:
    """Return a path that brings the driven joint to rest along a single cubic.

    The arguments are the same as those of ``direct_duration``.
    """
    duration = direct_duration(geometry, start, end, speed, shortest)
    ends = [start, geometry.position(end)]
    return _path(geometry, [0.0, duration], ends, [0.0, 0.0])


def direct_duration(
    geometry: ParallelGripper, start: float, end: float, speed: float, shortest: float
) -> float:
    """Return the duration of ``direct_path`` [s].

    The mean speed is two thirds of ``speed`` [m/s], because a cubic from rest reaches
    its maximum speed halfway. The duration of a short motion is the time that the pads
    need at their maximum acceleration.

    Args:
        geometry: The gripper.
        start: Current setpoint of the joint [rad | m].
        end: Distance between the pads at the end [m], within 0 …
            ``geometry.max_opening``.
        speed: Relative speed of the pads [m/s].
        shortest: Minimum duration that is returned [s].
    """
    distance = abs(end - geometry.opening(start))
    cruise = 1.5 * distance / speed
    ramp = math.sqrt(6.0 * distance * RAMP_TIME / geometry.speed[1])
    return max(cruise, ramp, shortest)


def _path(
    geometry: ParallelGripper,
    times: Sequence[float],
    positions: Sequence[float],
    velocities: Sequence[float],
) -> Path:
    return Path(
        joint_names=(geometry.joint,),
        times=np.array(times),
        positions=np.array(positions)[:, None],
        velocities=np.array(velocities)[:, None],
    )


def _ramped(
    done: float, distance: float, ramp: float, speed: float
) -> tuple[float, float]:
    """Return the time [s] and the speed [m/s] after a part ``done`` of a distance [m].

    The acceleration is constant over the distance ``ramp`` at both ends. Between the
    ramps, the speed is ``speed``.
    """
    if ramp <= 0.0:
        return 0.0, 0.0
    ramp_time = 2.0 * ramp / speed
    if done < ramp:
        return ramp_time * math.sqrt(done / ramp), speed * math.sqrt(done / ramp)
    cruise_time = ramp_time + (min(done, distance - ramp) - ramp) / speed
    left = distance - done
    if left >= ramp:
        return cruise_time, speed
    slow = math.sqrt(max(0.0, left / ramp))
    return cruise_time + ramp_time * (1.0 - slow), speed * slow
