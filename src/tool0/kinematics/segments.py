"""Pieces of a motion: joint positions over a distance x along a path.

For a joint segment x is the angle of the joint that turns most [rad], for a tool
segment it is the distance along the tool's path [m].
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol, final

import numpy as np

from tool0.errors import UnreachableError
from tool0.kinematics.blend import ToolState
from tool0.kinematics.chain import Array
from tool0.kinematics.inverse import InverseKinematics
from tool0.kinematics.profile import SpeedProfile
from tool0.kinematics.tool_path import PathFollower, ToolPath

STEP = 0.004
"""Distance between the poses that are solved [m]; less where the joints need it."""
STEP_ANGLE = 0.025
"""The same for rotations of the tool [rad]."""
MAX_STEPS = 20_000
"""Poses of the longest path: 80 m, which is far out of reach of any arm."""
_LONG = 500
"""Paths of more steps may be far out of reach: their end is solved first."""
TOLERANCE = 2e-5
"""Largest distance of the tool from its path between two knots [m]."""
_ROUNDS = 6
_SAME = 1e-9
"""Distances closer to each other than this, relative to the length, are the same."""
REMEDY = "choose another pose or via pose, start in another posture, or use movej"


class Knots(NamedTuple):
    """Times and states between which joints follow cubic polynomials."""

    times: Array
    """[s], shape (n,)."""
    q: Array
    """[rad], shape (n, 6)."""
    qd: Array
    """[rad/s], shape (n, 6)."""


class Segment(Protocol):
    """Joint positions over x, from 0 to ``length``."""

    length: float
    grid: Array
    """Every x at which a knot is needed, from 0 to the length."""

    @property
    def end(self) -> Array:
        """Joint positions at the end [rad], shape (6,)."""

    def at(self, x: Array) -> tuple[Array, Array]:
        """Return joint positions and their rates per x, shape (n, 6) each."""

    def tool_points(self, x: Array) -> Array:
        """Return where the tool is [m], shape (n, 3)."""

    def tool_state(self, x: float, speed: float) -> ToolState:
        """Return pose and motion of the tool there with a speed along the path."""


@final
class JointSegment:
    """Straight in the space of the joints: all turn in proportion."""

    def __init__(
        self, kinematics: InverseKinematics, start: Array, end: Array, T_tip_tool: Array
    ) -> None:
        self._chain = kinematics.chain
        self._T_tip_tool = T_tip_tool
        self._start, self.end = start, end
        self.length = float(np.abs(end - start).max())
        self.rate = (end - start) / max(self.length, 1e-300)
        """Of each joint per x, shape (6,)."""
        self.grid = np.array([0.0, self.length])

    def at(self, x: Array) -> tuple[Array, Array]:
        """Return joint positions and their rates per x, shape (n, 6) each."""
        left = (self.length - x)[:, None]
        near_start = (x < self.length / 2)[:, None]
        q = np.where(
            near_start,
            self._start + x[:, None] * self.rate,
            self.end - left * self.rate,
        )
        return q, np.broadcast_to(self.rate, q.shape)

    def tool_points(self, x: Array) -> Array:
        """Return where the tool is [m], shape (n, 3)."""
        q, _ = self.at(x)
        T = self._chain.forward(q).T_base_tip @ self._T_tip_tool
        return np.asarray(T[:, :3, 3])

    def tool_state(self, x: float, speed: float) -> ToolState:
        """Return pose and motion of the tool there with a speed along the path."""
        q, rate = self.at(np.array([x]))
        posture = self._chain.forward(q)
        T = posture.T_base_tip[0] @ self._T_tip_tool
        V = posture.jacobian[0] @ rate[0]
        V[:3] += np.cross(V[3:], T[:3, 3] - posture.T_base_tip[0, :3, 3])
        return ToolState(T, V * speed)


@final
class ToolSegment:
    """Along a path of the tool."""

    def __init__(
        self,
        kinematics: InverseKinematics,
        path: ToolPath,
        start: Array,
        length: float,
    ) -> None:
        """Solve for the path.

        Args:
            kinematics: The arm's.
            path: Of the tool.
            start: Joint positions at its start [rad], shape (6,).
            length: x at its end.

        Raises:
            UnreachableError: If the arm cannot follow it, with reason and place.
        """
        self._kinematics, self.path, self.length = kinematics, path, length
        self._follower = PathFollower(kinematics, path, REMEDY)
        steps = max(path.length / STEP, path.angle / STEP_ANGLE)
        if steps > _LONG:
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
        """Joint positions at the end [rad], shape (6,)."""
        return np.asarray(self._q[-1])

    def at(self, x: Array) -> tuple[Array, Array]:
        """Return joint positions and their rates per x, shape (n, 6) each."""
        s = np.clip(x / self.length, 0.0, 1.0)
        k = np.minimum(np.searchsorted(self._s, s), len(self._s) - 1)
        q, rate = self._q[k], self._rate[k]
        between = self._s[k] != s
        if between.any():
            s = s[between]
            guess = sampled(Knots(self._s, self._q, self._rate), s).q
            solved = self._kinematics.refined(guess, self.path.tip(s))
            if len(solved) != len(guess):
                raise UnreachableError(
                    f"lost the {self.path.noun} {self.path.at(s[0])}; {REMEDY}"
                )
            q[between] = solved
            rate[between] = self._follower.rate(s, solved)
        return q, rate / self.length

    def tool_points(self, x: Array) -> Array:
        """Return where the tool is [m], shape (n, 3)."""
        return np.asarray(self.path.tool(x / self.length)[:, :3, 3])

    def tool_state(self, x: float, speed: float) -> ToolState:
        """Return pose and motion of the tool there with a speed along the path."""
        s = np.array([x / self.length])
        T = self.path.tool(s)
        return ToolState(T[0], self.path.twist(s, T)[0] * (speed / self.length))

    def _refine(self, start: Array) -> None:
        """Solve more poses until the polynomials between them stay on the path."""
        for _ in range(_ROUNDS):
            middle = (self._s[:-1] + self._s[1:]) / 2.0
            q = sampled(Knots(self._s, self._q, self._rate), middle).q
            off = self._kinematics.chain.forward(q).T_base_tip - self.path.tip(middle)
            far = np.linalg.norm(off[:, :3, 3], axis=1) > TOLERANCE
            if not far.any():
                return
            self._s = np.sort(np.concatenate([self._s, middle[far]]))
            self._q = self._follower.follow(self._s, start)
            self._rate = self._follower.rate(self._s, self._q)
        raise UnreachableError(
            f"the {self.path.noun} passes a singularity "
            f"{self.path.at(float(middle[far.argmax()]))}; {REMEDY}"
        )


def knots(segment: Segment, profile: SpeedProfile, start: float = 0.0) -> Knots:
    """Return the knots of a segment that is passed from x = ``start`` on.

    The first one is at time 0.
    """
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
    return Knots(times[order], q, rate * speeds[order, None])


def sampled(motion: Knots, times: Array) -> Knots:
    """Return the motion at other times within it."""
    k = np.searchsorted(motion.times, times, side="right") - 1
    k = np.clip(k, 0, len(motion.times) - 2)
    h = (motion.times[k + 1] - motion.times[k])[:, None]
    u = (times - motion.times[k])[:, None] / h
    here, there = motion.q[k], motion.q[k + 1]
    out, into = h * motion.qd[k], h * motion.qd[k + 1]
    q = (
        (1 + 2 * u) * (1 - u) ** 2 * here
        + u * (1 - u) ** 2 * out
        + u**2 * (3 - 2 * u) * there
        + u**2 * (u - 1) * into
    )
    slope = (
        6 * u * (1 - u) * (there - here)
        + (1 - u) * (1 - 3 * u) * out
        + u * (3 * u - 2) * into
    )
    return Knots(times, q, slope / h)


def distance_within(segment: Segment, radius: float, *, at_end: bool) -> float:
    """Return how far along a segment its tool stays within ``radius`` [m] of an end.

    From its start or, backwards, from its end; the whole length if it never leaves.
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
