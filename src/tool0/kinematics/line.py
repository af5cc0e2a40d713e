"""A straight line of poses, and a smooth timing along it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple, final

import numpy as np

from tool0.description.transform import from_matrix
from tool0.errors import ControlError
from tool0.kinematics.chain import Array, cross_matrix, rodrigues

if TYPE_CHECKING:
    import ruckig

MIN_PATH_SPEED = 1e-4
"""Smallest speed along a path [of its length per second]."""
_BISECTIONS = 40


@final
class LinePath:
    """Poses of a tool along a straight line, turning steadily about one axis.

    Poses are in the link that carries the arm; the path parameter s goes from 0 to 1.
    """

    noun = "line"

    def __init__(
        self,
        start: Array,
        end: Array,
        T_tip_tool: Array,
        T_root_base: Array | None = None,
    ) -> None:
        """Make the path; every pose has shape (4, 4).

        Args:
            start: Pose of the tool at the start.
            end: Pose of the tool at the end.
            T_tip_tool: Pose of the tool in the arm's flange.
            T_root_base: Pose of the arm's base, for messages.
        """
        self._T_root_base = np.eye(4) if T_root_base is None else T_root_base
        self._start = start
        self._T_tool_tip = np.linalg.inv(T_tip_tool)
        displacement = end[:3, 3] - start[:3, 3]
        turn = np.eye(4)
        turn[:3, :3] = end[:3, :3] @ start[:3, :3].T
        w, *xyz = from_matrix(turn).quat_wxyz
        self.length = float(np.linalg.norm(displacement))
        """[m]"""
        sine = float(np.linalg.norm(xyz))
        self.angle = 2.0 * math.atan2(sine, w)
        """[rad]"""
        axis = np.array(xyz) / sine if sine > 0.0 else np.zeros(3)
        self._displacement = displacement
        self._turn = axis * self.angle

    def tool(self, s: Array) -> Array:
        """Return the tool's pose at each s, shape (n, 4, 4)."""
        T = np.empty((len(s), 4, 4))
        T[:, :3, :3] = _rotations(self._turn, s) @ self._start[:3, :3]
        T[:, :3, 3] = self._start[:3, 3] + s[:, None] * self._displacement
        T[:, 3] = (0.0, 0.0, 0.0, 1.0)
        return T

    def tip(self, s: Array) -> Array:
        """Return the flange's pose at each s, shape (n, 4, 4)."""
        return np.asarray(self.tool(s) @ self._T_tool_tip)

    def twist(self, s: Array, T_base_tip: Array) -> Array:
        """Return the flange's motion per s, linear above angular, shape (n, 6)."""
        lever = T_base_tip[:, :3, 3] - self.tool(s)[:, :3, 3]
        linear = self._displacement + np.cross(self._turn, lever)
        angular = np.broadcast_to(self._turn, linear.shape)
        return np.concatenate([linear, angular], axis=1)

    def at(self, s: float) -> str:
        """Return the place of s on the path, as text."""
        pose = from_matrix(self._T_root_base @ self.tool(np.array([s]))[0])
        return f"at {s:.0%} of the line, where the tool is at {pose}"


def _rotations(rotation_vector: Array, s: Array) -> Array:
    """Return the rotations by ``s`` times a rotation vector, shape (n, 3, 3)."""
    angle = float(np.linalg.norm(rotation_vector))
    if angle == 0.0:
        return np.broadcast_to(np.eye(3), (len(s), 3, 3))
    K = cross_matrix(*(rotation_vector / angle))
    return rodrigues(K, K @ K, angle * s)


class PathSegment(NamedTuple):
    """A segment of a path, and the limits on it; the path parameter is s."""

    end: float
    """The s of its end; it starts at the end of the segment before."""
    speed: float
    """[1/s]"""
    acceleration: float
    """[1/s²]"""
    jerk: float
    """[1/s³]"""


@final
class PathTiming:
    """s as a function of time, from rest at 0 to rest at 1.

    The speed is steady where two segments meet: it changes within them.
    """

    def __init__(self, segments: Sequence[PathSegment]) -> None:
        import ruckig  # without annotations: its values are Any

        speeds = _border_speeds(segments)
        self._parts: list[ruckig.Trajectory] = []
        self._starts: list[float] = []
        self.duration = 0.0
        """[s]"""
        start = 0.0
        planner = ruckig.Ruckig(1)
        for segment, before, after in zip(segments, speeds, speeds[1:], strict=False):
            request = ruckig.InputParameter(1)
            request.current_position, request.target_position = [start], [segment.end]
            request.current_velocity, request.target_velocity = [before], [after]
            request.max_velocity = [max(segment.speed, before, after)]
            request.max_acceleration = [segment.acceleration]
            request.max_jerk = [segment.jerk]
            part = ruckig.Trajectory(1)
            try:
                planner.calculate(request, part)
            except ruckig.RuckigError:
                raise ControlError(
                    "found no timing for the line: speed, acceleration or angular "
                    "speed are too extreme; the usual ones are 0.25 m/s, 1.2 m/s² and "
                    "1 rad/s"
                ) from None
            self._parts.append(part)
            self._starts.append(self.duration)
            self.duration += part.duration
            start = segment.end

    def at(self, times: Array) -> Array:
        """Return s [0 … 1], its speed [1/s] and acceleration [1/s²], shape (n, 3)."""
        parts = np.searchsorted(self._starts, times, side="right") - 1
        rows = [
            [values[0] for values in self._parts[k].at_time(time - self._starts[k])]
            for k, time in zip(parts.tolist(), times.tolist(), strict=True)
        ]
        return np.array(rows)


def _border_speeds(segments: Sequence[PathSegment]) -> list[float]:
    """Return the speed at each border: the most that both sides can reach."""
    inner = [min(a.speed, b.speed) for a, b in itertools.pairwise(segments)]
    speeds = [0.0, *inner, 0.0]
    ends = [0.0, *(segment.end for segment in segments)]
    forward = [(k, k, k + 1) for k in range(len(segments))]
    backward = [(k, k + 1, k) for k in reversed(range(len(segments)))]
    for k, known, limited in forward + backward:
        reached = _fastest_after(speeds[known], ends[k + 1] - ends[k], segments[k])
        speeds[limited] = min(speeds[limited], reached)
    return speeds


def _fastest_after(speed: float, length: float, segment: PathSegment) -> float:
    """Return the largest speed that can be reached from ``speed`` on ``length``."""
    low, high = speed, max(segment.speed, speed)
    if _length_between(speed, high, segment) <= length:
        return high
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2.0
        if _length_between(speed, middle, segment) <= length:
            low = middle
        else:
            high = middle
    return low


def _length_between(slow: float, fast: float, segment: PathSegment) -> float:
    """Return the length on which a speed changes to another, both steady."""
    change = fast - slow
    a, j = segment.acceleration, segment.jerk
    time = change / a + a / j if change >= a * a / j else 2.0 * (change / j) ** 0.5
    return (slow + fast) / 2.0 * time
