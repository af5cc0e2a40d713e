"""Segments of a motion: joint positions over a distance x along a path.

For a joint segment, x is the angle of the joint that turns most [rad]; for a tool
segment, x is the distance along the tool's path [m].
"""

from __future__ import annotations

import math
from typing import Protocol, final

import numpy as np

from tool0.errors import UnreachableError
from tool0.kinematics.chain import Array
from tool0.motion.blend import ToolState
from tool0.motion.path import Cubics
from tool0.motion.profile import SpeedProfile
from tool0.motion.tool_path import PathFollower, ToolOfArm, ToolPath

MAX_STEPS = 20_000
"""Maximum number of poses of a path. The number corresponds to a path of 80 m, far
beyond any arm's reach."""
_ROUNDS = 6
_SAME = 1e-9
"""Difference, relative to the length, below which two distances are considered
equal."""


class PathSegment(Protocol):
    """Joint positions over x, where x goes from 0 to ``length``."""

    length: float
    grid: Array
    """All values of x at which a knot is needed, from 0 to ``length``."""

    @property
    def end(self) -> Array:
        """Joint positions at the end of the segment [rad], shape (6,)."""

    def at(self, x: Array) -> tuple[Array, Array]:
        """Return the joint positions and their x derivatives, each of shape (n, 6)."""

    def tool_points(self, x: Array) -> Array:
        """Return the positions of the tool at ``x`` [m], shape (n, 3)."""

    def tool_state(self, x: float, speed: float) -> ToolState:
        """Return the state of the tool at ``x`` with a speed along the path."""


@final
class JointSegment:
    """Segment along a straight line in joint space."""

    def __init__(self, tool: ToolOfArm, start: Array, end: Array) -> None:
        self._tool = tool
        self._start, self.end = start, end
        self.length = float(np.abs(end - start).max())
        self.rate = (end - start) / max(self.length, 1e-300)
        """Change of each joint position per unit of x, shape (6,)."""
        self.grid = np.array([0.0, self.length])

    def at(self, x: Array) -> tuple[Array, Array]:
        """Return the joint positions and their x derivatives, each of shape (n, 6)."""
        left = (self.length - x)[:, None]
        near_start = (x < self.length / 2)[:, None]
        q = np.where(
            near_start,
            self._start + x[:, None] * self.rate,
            self.end - left * self.rate,
        )
        return q, np.broadcast_to(self.rate, q.shape)

    def tool_points(self, x: Array) -> Array:
        """Return the positions of the tool at ``x`` [m], shape (n, 3)."""
        q, _ = self.at(x)
        return np.asarray(self._tool.pose(q)[:, :3, 3])

    def tool_state(self, x: float, speed: float) -> ToolState:
        """Return the state of the tool at ``x`` with a speed along the path."""
        q, rate = self.at(np.array([x]))
        posture = self._tool.kinematics.chain.forward(q)
        T = posture.T_base_tip[0] @ self._tool.T_tip_tool
        V = posture.jacobian[0] @ rate[0]
        V[:3] += np.cross(V[3:], T[:3, 3] - posture.T_base_tip[0, :3, 3])
        return ToolState(T, V * speed)


@final
class ToolSegment:
    """Segment along the path of a tool."""

    def __init__(
        self, tool: ToolOfArm, path: ToolPath, start: Array, length: float
    ) -> None:
        """Solve the inverse kinematics along the path.

        Args:
            tool: Tool that follows the path.
            path: Path of the tool.
            start: Joint positions at the start of the path [rad], shape (6,).
            length: Value of x at the end of the path.

        Raises:
            UnreachableError: If the arm cannot follow the path; the message states the
                reason and the place.
        """
        self._kinematics, self._rules = tool.kinematics, tool.rules
        self.path, self.length = path, length
        self._follower = PathFollower(tool, path)
        steps = max(path.length / self._rules.step, path.angle / self._rules.step_angle)
        if steps > self._rules.unchecked_steps:
            self._follower.check_end(start)
        if steps > MAX_STEPS:
            raise UnreachableError(f"a path of {path.length:.6g} m is too long")
        self._s = np.linspace(0.0, 1.0, max(math.ceil(steps), 4) + 1)
        self._q = self._follower.follow(self._s, start)
        self._rate = self._follower.rate(self._s, self._q)
        self._refine(start)
        self.grid = self._s * length

    @property
    def end(self) -> Array:
        """Joint positions at the end of the segment [rad], shape (6,)."""
        return np.asarray(self._q[-1])

    def at(self, x: Array) -> tuple[Array, Array]:
        """Return the joint positions and their x derivatives, each of shape (n, 6)."""
        s = np.clip(x / self.length, 0.0, 1.0)
        k = np.minimum(np.searchsorted(self._s, s), len(self._s) - 1)
        q, rate = self._q[k], self._rate[k]
        between = self._s[k] != s
        if between.any():
            s = s[between]
            guess = Cubics(self._s, self._q, self._rate).at(s).q
            solved = self._kinematics.refined(guess, self._follower.tip(s))
            if len(solved) != len(guess):
                raise UnreachableError(
                    f"lost the {self.path.noun} {self._follower.place(s[0])}; "
                    f"{self._rules.remedy}"
                )
            q[between] = solved
            rate[between] = self._follower.rate(s, solved)
        return q, rate / self.length

    def tool_points(self, x: Array) -> Array:
        """Return the positions of the tool at ``x`` [m], shape (n, 3)."""
        return np.asarray(self.path.tool(x / self.length)[:, :3, 3])

    def tool_state(self, x: float, speed: float) -> ToolState:
        """Return the state of the tool at ``x`` with a speed along the path."""
        s = np.array([x / self.length])
        T = self.path.tool(s)
        return ToolState(T[0], self.path.twist(s, T)[0] * (speed / self.length))

    def _refine(self, start: Array) -> None:
        """Solve additional poses until the cubics between them stay on the path."""
        for _ in range(_ROUNDS):
            middle = (self._s[:-1] + self._s[1:]) / 2.0
            q = Cubics(self._s, self._q, self._rate).at(middle).q
            T_base_tip = self._kinematics.chain.forward(q).T_base_tip
            off = T_base_tip - self._follower.tip(middle)
            far = np.linalg.norm(off[:, :3, 3], axis=1) > self._rules.tolerance
            if not far.any():
                return
            self._s = np.sort(np.concatenate([self._s, middle[far]]))
            self._q = self._follower.follow(self._s, start)
            self._rate = self._follower.rate(self._s, self._q)
        raise UnreachableError(
            f"the {self.path.noun} passes a singularity "
            f"{self._follower.place(float(middle[far.argmax()]))}; {self._rules.remedy}"
        )


def passage(segment: PathSegment, profile: SpeedProfile, start: float = 0.0) -> Cubics:
    """Return the motion along a segment, starting at x = ``start``."""
    within = profile.distances
    margin = _SAME * segment.length
    inner = segment.grid - start
    inner = inner[(inner > margin) & (inner < within[-1] - margin)]
    away = np.abs(inner[:, None] - within).min(axis=1, initial=np.inf) > margin
    x = np.concatenate([within, inner[away]])
    times = np.concatenate([profile.times, profile.times_at(inner[away])])
    speeds = np.concatenate([profile.speeds, profile.speed_at(inner[away])])
    order = np.argsort(times, kind="stable")
    q, rate = segment.at(np.clip(start + x[order], 0.0, segment.length))
    return Cubics(times[order], q, rate * speeds[order, None])


def distance_within(segment: PathSegment, radius: float, *, at_end: bool) -> float:
    """Return the length of a segment's part within ``radius`` [m] of one end.

    The part begins at the segment's start or, with ``at_end``, at its end. If the tool
    never leaves the radius, the result is the length of the whole segment.
    """
    centre = segment.tool_points(np.array([segment.length if at_end else 0.0]))
    inside, outside = 0.0, segment.length
    for _ in range(3):
        x = np.linspace(inside, outside, 33)
        points = segment.tool_points(segment.length - x if at_end else x)
        beyond = np.linalg.norm(points - centre, axis=1) > radius
        if not beyond.any():
            return outside
        first = int(beyond.argmax())
        inside, outside = float(x[first - 1]), float(x[first])
    return inside
