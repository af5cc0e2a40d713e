"""Straight motion of a tool: joint positions along a line, and their timing."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from tool0.errors import ControlError, UnreachableError
from tool0.kinematics.chain import Array
from tool0.kinematics.inverse import InverseKinematics
from tool0.kinematics.line import MIN_PATH_SPEED, LinePath, PathSegment, PathTiming
from tool0.kinematics.tool_path import PathFollower
from tool0.protocol.trajectories import TrajectoryPoint
from tool0.runtime.joint_motion import TIME_TO_FULL_ACCELERATION

STEP = 0.002
"""Distance between the poses that are solved [m]."""
STEP_ANGLE = 0.01
"""The same for rotations of the tool [rad]."""
MAX_STEPS = 20_000
"""Poses of the longest line: 40 m, which is far out of reach of any arm."""
PERIOD = 0.008
"""Time between points at least [s]: the rate of a UR's own interface, 125 Hz."""
MIN_POINTS = 300
"""Least number of points unless PERIOD allows fewer; more where the line is long."""
_LEVEL = 0.7
"""Ratio between the speeds that segments of a line may have."""
_SHARE = 0.5
"""Part of a joint's acceleration for each of the two that add up: by the acceleration
along the line, and by the curvature of the joint path at steady speed."""
_REMEDY = "choose another line, start in another branch, or use move_to"


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class LinearLimits:
    """Limits of the tool's motion; those of the joints apply as well."""

    speed: float
    """[m/s]"""
    acceleration: float
    """[m/s²]"""
    angular_speed: float
    """[rad/s]"""

    def __post_init__(self) -> None:
        for name in ("speed", "acceleration", "angular_speed"):
            value = getattr(self, name)
            if not 0.0 < value < math.inf:
                raise ControlError(f"{name} must be above 0 and finite, got {value}")


@final
class LinearMotion:
    """A checked line: the arm reaches every point of it, and no joint jumps."""

    def __init__(
        self,
        kinematics: InverseKinematics,
        line: LinePath,
        start: Array,
        limits: LinearLimits,
        joint_accelerations: Sequence[float],
    ) -> None:
        """Plan the motion.

        Args:
            kinematics: The arm's.
            line: The line for its tool.
            start: Joint positions at the start [rad], shape (6,).
            limits: Limits of the tool's motion.
            joint_accelerations: Largest accelerations of the joints [rad/s²], (6,).

        Raises:
            UnreachableError: If the arm cannot follow it, with reason and place.
        """
        self._kinematics = kinematics
        self._line = line
        self._follower = PathFollower(kinematics, line, _REMEDY)
        self._limits = limits
        self._strongest = np.asarray(joint_accelerations)
        steps = max(line.length / STEP, line.angle / STEP_ANGLE)
        if steps < 1e-6:
            raise ControlError("the tool is already there: the line has no length")
        self._follower.check_end(start)
        if steps > MAX_STEPS:
            raise UnreachableError(
                f"a line of {line.length:.6g} m is too long; the longest is "
                f"{MAX_STEPS * STEP:g} m"
            )
        self._s = np.linspace(0.0, 1.0, max(math.ceil(steps), 8) + 1)
        self._q = self._follower.follow(self._s, start)
        self._timing = PathTiming(self._segments())
        self.duration = self._timing.duration
        """[s]"""

    def points(self) -> list[TrajectoryPoint]:
        """Return the motion as points with velocities and accelerations."""
        line, T = self._line, self.duration
        fine = max(2 * line.length / STEP, 2 * line.angle / STEP_ANGLE, MIN_POINTS)
        n = math.ceil(min(T / PERIOD, fine))
        times = T * np.arange(1, n + 1) / n
        s, sd, sdd = self._timing.at(times).T
        s = np.clip(s, 0.0, 1.0)
        guess = np.stack([np.interp(s, self._s, q) for q in self._q.T], axis=1)
        q = self._kinematics.refined(guess, line.tip(s))
        if len(q) != len(guess):
            raise UnreachableError("lost the line between two of its points")
        rate, curvature = self._follower.rates(s, q)
        qd = rate * sd[:, None]
        qdd = rate * sdd[:, None] + curvature * sd[:, None] ** 2
        qd[-1] = qdd[-1] = 0.0
        rows = zip(q.tolist(), qd.tolist(), qdd.tolist(), times.tolist(), strict=True)
        return [TrajectoryPoint(*row) for row in rows]

    def _segments(self) -> list[PathSegment]:
        """Return the limits of tool and joints along the line."""
        rate, curvature = self._follower.rates(self._s, self._q)
        rate, curvature = np.abs(rate), np.abs(curvature)
        fastest = self._kinematics.fastest
        strongest = self._strongest
        line, limits = self._line, self._limits
        ramp = limits.speed / limits.acceleration
        with np.errstate(divide="ignore"):
            top = min(
                float(np.divide(limits.speed, line.length)),
                float(np.divide(limits.angular_speed, line.angle)),
            )
            by_speed = (fastest / rate).min(axis=1)
            by_curvature = np.sqrt(_SHARE * strongest / curvature).min(axis=1)
            by_acceleration = (_SHARE * strongest / rate).min(axis=1)
        caps = np.minimum(by_speed, by_curvature)
        slowest = int(caps.argmin())
        if caps[slowest] < MIN_PATH_SPEED:
            where = line.at(self._s[slowest])
            raise UnreachableError(f"the line passes a singularity {where}; {_REMEDY}")
        # Few segments, each as fast as its slowest point: speed changes take length.
        between = np.minimum(caps[:-1], caps[1:]) / top
        levels = np.ceil(np.log(np.minimum(between, 1.0)) / np.log(_LEVEL) - 1e-9)
        borders = [0, *(np.flatnonzero(np.diff(levels)) + 1), len(levels)]
        segments = []
        for first, last in itertools.pairwise(borders):
            within = float(by_acceleration[first : last + 1].min())
            acceleration = min(top / ramp, within)
            segments.append(
                PathSegment(
                    end=float(self._s[last]),
                    speed=top * _LEVEL ** float(levels[first]),
                    acceleration=acceleration,
                    jerk=acceleration / TIME_TO_FULL_ACCELERATION,
                )
            )
        return segments
