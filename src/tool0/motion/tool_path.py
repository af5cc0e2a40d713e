"""Paths of a tool, and joint positions that follow these paths without jumps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, final

import numpy as np

from tool0.description.transform import from_matrix
from tool0.errors import UnreachableError
from tool0.kinematics.chain import Array
from tool0.kinematics.geometry import wrapped
from tool0.kinematics.inverse import InverseKinematics
from tool0.motion.rules import MoveRules

MAX_JOINT_STEP = 0.3
"""Rotation of a joint in one step above which it is considered a jump [rad]. At 2 mm
per step, the value is 150 rad/m, so a line at 20 mm/s would need the joint's maximum
velocity."""


class ToolPath(Protocol):
    """Poses of a tool as a function of a path parameter s from 0 to 1.

    Poses are in the frame of the arm's base link.
    """

    @property
    def noun(self) -> str:
        """Noun for error messages, such as ``line``."""

    @property
    def length(self) -> float:
        """Length of the tool's path [m]."""

    @property
    def angle(self) -> float:
        """Angle by which the tool turns [rad]."""

    def tool(self, s: Array) -> Array:
        """Return the tool's pose at each s, shape (n, 4, 4)."""

    def twist(self, s: Array, T_base_tip: Array) -> Array:
        """Return the twist per unit of s of a frame fixed to the tool, shape (n, 6).

        Linear components come before angular components. The pose of the frame is
        ``T_base_tip``, shape (n, 4, 4).
        """


@final
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ToolOfArm:
    """An arm with a tool and the rules for its moves."""

    kinematics: InverseKinematics
    T_tip_tool: Array
    """Pose of the tool in the flange's frame, shape (4, 4)."""
    T_root_base: Array
    """Pose of the arm's base link in the root frame, for error messages, shape (4,
    4)."""
    rules: MoveRules

    def pose(self, q: Array) -> Array:
        """Return the tool's pose at joint positions ``q`` [rad], shape (n, 4, 4)."""
        return np.asarray(self.kinematics.chain.forward(q).T_base_tip @ self.T_tip_tool)


@final
class PathFollower:
    """Joint positions along a path of a tool, and their derivatives."""

    def __init__(self, tool: ToolOfArm, path: ToolPath) -> None:
        self._kinematics, self._path = tool.kinematics, path
        self._T_tool_tip = np.linalg.inv(tool.T_tip_tool)
        self._T_root_base, self._remedy = tool.T_root_base, tool.rules.remedy

    def tip(self, s: Array) -> Array:
        """Return the flange's pose at each s, shape (n, 4, 4)."""
        return np.asarray(self._path.tool(s) @ self._T_tool_tip)

    def place(self, s: float) -> str:
        """Return the position of s on the path as text for error messages."""
        pose = from_matrix(self._T_root_base @ self._path.tool(np.array([s]))[0])
        return f"at {s:.0%} of the {self._path.noun}, where the tool is at {pose}"

    def check_end(self, start: Array) -> None:
        """Raise UnreachableError if the arm cannot reach the end of the path."""
        end = self.tip(np.ones(1))[0]
        if not len(self._kinematics.postures(end, start)):
            raise self._no_solution(1.0, start)

    def follow(self, s: Array, start: Array) -> Array:
        """Return continuous joint positions at all values of s, shape (n, 6).

        At each s, the solution that is closest to the previous solution is used.

        Raises:
            UnreachableError: If a pose cannot be reached, or if a joint jumps or
                exceeds its limits; the message states the place.
        """
        kinematics, noun = self._kinematics, self._path.noun
        poses = self.tip(s)
        every = kinematics.geometry.solve(poses)
        found = np.empty((len(poses), 6))
        found[0] = q = start
        for k in range(1, len(poses)):
            turns = wrapped(every[k] - q)
            sizes = np.abs(turns).max(axis=1)
            sizes[np.isnan(sizes)] = np.inf
            nearest = int(sizes.argmin())
            if np.isinf(sizes[nearest]):
                raise self._no_solution(s[k], q)
            if sizes[nearest] > MAX_JOINT_STEP:
                joint = kinematics.chain.joints[int(np.abs(turns[nearest]).argmax())]
                raise UnreachableError(
                    f"the {noun} passes a singularity, or the reach of "
                    f"'{kinematics.branch(q)}' ends: joint '{joint.name}' would have "
                    f"to jump by {sizes[nearest]:.2f} rad {self.place(s[k])}; "
                    f"{self._remedy}"
                )
            found[k] = q = q + turns[nearest]
        refined = kinematics.refined(found, poses)
        if len(refined) != len(found):
            raise UnreachableError(
                f"the {noun} passes too close to a singularity; {self._remedy}"
            )
        self._check_limits(s, refined)
        return refined

    def rate(self, s: Array, q: Array) -> Array:
        """Return the derivative dq/ds, shape (n, 6)."""
        posture = self._kinematics.chain.forward(q)
        twist = self._path.twist(s, posture.T_base_tip)
        try:
            solved = np.linalg.solve(posture.jacobian, twist[..., None])
        except np.linalg.LinAlgError:
            raise UnreachableError(
                f"the {self._path.noun} starts at or passes through a singularity "
                f"of the arm; {self._remedy}"
            ) from None
        return np.asarray(solved[..., 0], dtype=np.float64)

    def _no_solution(self, s: float, q: Array) -> UnreachableError:
        noun, place = self._path.noun, self.place(s)
        try:
            self._kinematics.solutions(self.tip(np.array([s]))[0], q)
        except UnreachableError as error:
            return UnreachableError(f"the {noun} cannot be followed: {error}; {place}")
        return UnreachableError(f"the {noun} cannot be followed {place}")

    def _check_limits(self, s: Array, q: Array) -> None:
        for k, joint in enumerate(self._kinematics.chain.joints):
            lower, upper = joint.limits.range_from(float(q[0, k]))
            outside = (q[:, k] < lower - 1e-6) | (q[:, k] > upper + 1e-6)
            if outside.any():
                raise UnreachableError(
                    f"joint '{joint.name}' would leave its limits "
                    f"[{joint.limits.lower:.3f}, {joint.limits.upper:.3f}] rad "
                    f"{self.place(s[outside.argmax()])}"
                )
