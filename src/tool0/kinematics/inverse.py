"""Inverse kinematics of an arm, with all postures within the joint limits."""

from __future__ import annotations

import math
from typing import final

import numpy as np
from numpy.typing import NDArray

from tool0.description.model import JointType
from tool0.description.posture import Branch, Solution
from tool0.description.transform_arrays import sine_vectors
from tool0.description.units import LENGTH
from tool0.errors import ControlError, UnreachableError
from tool0.kinematics.chain import ArmChain, Array
from tool0.kinematics.geometry import SINGULAR, ArmGeometry, wrapped

_NEAREST = 0.05
"""Fraction of the reach that a distance must exceed after its conversion from
millimeters, so that an error message suggests millimeters."""
PRECISION = 1e-9
"""Maximum error of a solution's pose [m, rad]."""
EXACT = 1e-6
"""Deviation from the ideal geometry below which solutions need no refinement [rad]."""
_SAME = 1e-6
"""Difference below which two postures are considered equal [rad]."""
_LIMIT_ROUNDING = 1e-9
"""Maximum violation of a limit that is clipped instead of rejected [rad]."""
_STEPS = 12
_DAMPING = 1e-12


@final
class InverseKinematics:
    """Inverse kinematics of an arm, for flange poses in the frame of its base link."""

    def __init__(self, chain: ArmChain) -> None:
        self.chain = chain
        self.geometry = ArmGeometry(chain)
        limits = [joint.limits for joint in chain.joints]
        endless = [joint.type is JointType.CONTINUOUS for joint in chain.joints]
        self.lower = np.where(endless, -np.inf, [item.lower for item in limits])
        self.upper = np.where(endless, np.inf, [item.upper for item in limits])
        """Position limits [rad], each of shape (6,); infinite for joints without
        limits."""
        self.fastest = np.array([joint.max_velocity for joint in chain.joints])
        """Maximum velocities of the joints [rad/s], shape (6,)."""

    def solutions(
        self, T_base_tip: Array, near: Array, branch: Branch | None = None
    ) -> tuple[Solution, ...]:
        """Return all postures within the joint limits, nearest first.

        Args:
            T_base_tip: Target pose of the flange, shape (4, 4).
            near: Reference positions [rad], shape (6,). Each joint position is shifted
                by whole turns to be as near to the reference as possible.
            branch: Branch of the postures to return; by default, all branches.

        Raises:
            UnreachableError: If no posture reaches the pose; the message contains the
                reason.
        """
        if not isinstance(branch, Branch | None):
            raise ControlError(
                f'a branch must be as Branch(elbow="up"), got {branch!r}'
            )
        every = self.postures(T_base_tip, near)
        if not len(every):
            raise UnreachableError(self._why_none(T_base_tip))
        turned = self._turned(every, near)
        allowed = np.isfinite(turned).all(axis=1)
        if not allowed.any():
            raise UnreachableError(self._why_not_allowed(every))
        found = self._as_solutions(turned[allowed], near)
        wanted = tuple(
            item for item in found if (branch or Branch()).includes(item.branch)
        )
        if not wanted:
            others = "; ".join(str(item.branch) for item in found)
            raise UnreachableError(
                f"no posture of the branch '{branch}' reaches the pose within the "
                f"joints' limits; these do: {others}"
            )
        return wanted

    def postures(self, T_base_tip: Array, near: Array) -> Array:
        """Return all postures regardless of the joint limits [rad], shape (n, 6)."""
        poses = T_base_tip[None]
        found = self.geometry.solve(poses)[0]
        wrist = np.abs(self.geometry.signs(found).wrist)
        if not np.isfinite(found).any() or (wrist < SINGULAR).any():
            open_sixth = self.geometry.solve(poses, near[5:])[0]
            found = np.concatenate([open_sixth, found])
        if self.geometry.inexact > EXACT:  # may be the only start that converges
            found = np.concatenate([near[None], found])
        found = self.refined(found[np.isfinite(found).all(axis=1)], T_base_tip)
        apart = np.abs(wrapped(found[:, None] - found)).max(axis=2, initial=0.0)
        repeats = np.tril(apart <= _SAME, -1).any(axis=1)
        return np.asarray(found[~repeats])

    def refined(self, q: Array, T_base_tip: Array) -> Array:
        """Refine postures by Newton's method; return the ones that reach their poses.

        The closed form is exact only for the ideal arm. A calibrated arm differs
        slightly from the ideal arm. ``q`` is in [rad], shape (n, 6); ``T_base_tip`` has
        shape (4, 4) or (n, 4, 4).
        """
        found, has_reached = self._newton(q, T_base_tip)
        return np.asarray(found[has_reached])

    def nearest(self, T_base_tip: Array, near: Array) -> Array:
        """Return the nearest posture within the joint limits for each of n poses [rad].

        Singular poses, which do not determine all joints, are not supported.

        Args:
            T_base_tip: Target poses of the flange, shape (n, 4, 4).
            near: Reference positions [rad], shape (n, 6).

        Returns:
            Joint positions [rad], shape (n, 6). The rows of poses that no posture
            reaches are NaN.
        """
        every = self.geometry.solve(T_base_tip)
        turned = self._turned(every, near[:, None])
        distances = np.linalg.norm((turned - near[:, None]) / self.fastest, axis=2)
        best = np.nan_to_num(distances, nan=np.inf).argmin(axis=1)
        found = turned[np.arange(len(near)), best]
        is_found = np.isfinite(found).all(axis=1)
        if self.geometry.inexact > EXACT and is_found.any():
            q, has_reached = self._newton(found[is_found], T_base_tip[is_found])
            found[is_found] = np.where(has_reached[:, None], q, np.nan)
        found[~is_found] = np.nan
        return np.asarray(found)

    def _newton(self, q: Array, T_base_tip: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Return postures closer to their poses, and whether they reach them."""
        q = q.copy()
        for step in range(_STEPS + 1):
            posture = self.chain.forward(q)
            error = _twist(posture.T_base_tip, T_base_tip)
            sizes = np.abs(error).max(axis=1, initial=0.0)
            away = sizes > PRECISION / 10
            if step == _STEPS or not away.any():
                break
            J = posture.jacobian[away]
            Jt = J.swapaxes(1, 2)
            solved = np.linalg.solve(
                J @ Jt + _DAMPING * np.eye(6), error[away, :, None]
            )
            q[away] += np.clip((Jt @ solved)[..., 0], -0.1, 0.1)
        return q, sizes <= PRECISION

    def branch(self, q: Array) -> Branch:
        """Return the branch of a posture of shape (6,)."""
        shoulder, elbow, wrist = (sign[0] for sign in self.geometry.signs(q[None]))
        side = shoulder if self.geometry.lateral >= 0.0 else -shoulder
        return Branch(
            shoulder="left" if side >= 0.0 else "right",
            elbow="up" if shoulder * elbow >= 0.0 else "down",
            wrist="flip" if wrist >= 0.0 else "no_flip",
        )

    def _turned(self, q: Array, near: Array) -> Array:
        """Return ``q`` shifted by whole turns to be nearest to ``near``, or NaN."""
        nearest = near + wrapped(q - near)
        turn = 2 * np.pi
        lower, upper = self.lower - _LIMIT_ROUNDING, self.upper + _LIMIT_ROUNDING
        with np.errstate(invalid="ignore"):
            below = np.where(nearest < lower, np.ceil((lower - nearest) / turn), 0.0)
            above = np.where(nearest > upper, np.ceil((nearest - upper) / turn), 0.0)
        nearest = nearest + turn * (below - above)
        outside = (nearest < lower) | (nearest > upper)
        clipped = np.clip(nearest, self.lower, self.upper)
        return np.where(outside, np.nan, clipped)

    def _as_solutions(self, q: Array, near: Array) -> list[Solution]:
        distances = np.linalg.norm((q - near) / self.fastest, axis=1)
        names = self.chain.joint_names
        return [
            Solution(
                positions=dict(zip(names, q[k].tolist(), strict=True)),
                branch=self.branch(q[k]),
                distance=float(distances[k]),
            )
            for k in np.argsort(distances, kind="stable")
        ]

    def _why_none(self, T_base_tip: Array) -> str:
        geometry = self.geometry
        x, y, z = geometry.wrist_centre(T_base_tip[None])[0]
        beside = math.hypot(x, y)
        inside = math.sqrt(max(0.0, beside**2 - geometry.lateral**2))
        distance = math.hypot(inside, z)
        wrist = "the centre of the wrist (where the last two axes meet) would be"
        if beside < abs(geometry.lateral):
            return (
                f"out of reach: {wrist} {beside:.3f} m from the axis of the base, and "
                f"cannot come nearer than {abs(geometry.lateral):.3f} m"
            )
        if distance > (reach := geometry.reach):
            in_mm = LENGTH.suggestion(
                distance, lambda meant: _NEAREST * reach < meant <= reach
            )
            return (
                f"out of reach: {wrist} {distance:.3f} m from the shoulder, and the "
                f"arm reaches {reach:.3f} m{in_mm}"
            )
        return (
            f"out of reach with this orientation: {wrist} {distance:.3f} m from the "
            "shoulder, and the elbow can neither stretch nor bend that far; turn the "
            "tool, or move it"
        )

    def _why_not_allowed(self, q: Array) -> str:
        bad = []
        outside = ~np.isfinite(self._turned(q, np.clip(0.0, self.lower, self.upper)))
        for k in np.flatnonzero(outside.any(axis=0)):
            joint = self.chain.joints[k]
            where = ", ".join(f"{value:.3f}" for value in wrapped(q[outside[:, k], k]))
            bad.append(
                f"'{joint.name}' would be at {where} rad, outside "
                f"[{joint.limits.lower:.3f}, {joint.limits.upper:.3f}]"
            )
        return "joint limits exclude every posture: " + "; ".join(bad)


def _twist(T: Array, T_wanted: Array) -> Array:
    """Return the twist from ``T`` to ``T_wanted``, shape (n, 6).

    The result is exact if the twist is small.
    """
    R = T_wanted[..., :3, :3] @ T[:, :3, :3].swapaxes(1, 2)
    turn = sine_vectors(R)
    # Above 90 degrees, the sine decreases again, so a large value is used instead.
    far = np.trace(R, axis1=1, axis2=2) < 1.0
    turn[far] = np.where(turn[far] >= 0.0, 2.0, -2.0)
    linear = T_wanted[..., :3, 3] - T[:, :3, 3]
    return np.concatenate([linear, turn / 2], axis=1)
