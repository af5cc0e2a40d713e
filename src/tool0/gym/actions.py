"""Converts actions of n copies to joint and gripper targets."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tool0.description.transform_arrays import Frames, from_rotation_vectors
from tool0.errors import ControlError
from tool0.gym.options import EnvOptions
from tool0.gym.tool import raised
from tool0.gym.workspace import Workspace
from tool0.kinematics.chain import Array

LINEAR_SPEED = 0.4
"""Speed of the TCP at an action of 1, for an arm of scale 1 [m/s]."""
TURN_SPEED = 1.5
"""Angular speed of the tool at an action of 1 [rad/s]."""
JOINT_SPEED = 0.5
"""Speed of a joint at an action of 1, as a fraction of its velocity limit."""
FASTEST = 0.9
"""Largest speed of a joint, as a fraction of its velocity limit."""
LEAD = 0.25
"""Largest distance between a joint's target and its measured position, which limits the
targets of blocked joints [rad]."""
MARGIN = 0.02
"""Smallest distance between a target and the joint limits [rad]."""
NAMES = {
    "joint": (),
    "cartesian": ("x", "y", "z", "yaw"),
    "pose": ("x", "y", "z", "rx", "ry", "rz"),
}


@final
class Actions:
    """Actions of n copies: numbers within -1 … 1, grouped by arm."""

    def __init__(self, arms: Sequence[ArmActions]) -> None:
        self.names = tuple(name for arm in arms for name in arm.names)
        """Names of the numbers, such as joint or axis names."""
        ends = np.cumsum([len(arm.names) for arm in arms]).tolist()
        self._parts = [slice(*part) for part in itertools.pairwise([0, *ends])]
        self.grippers = tuple(end - 1 for end in ends)
        """Indices of the numbers that are gripper openings."""

    def checked(self, actions: ArrayLike, n: int) -> Array:
        """Return actions of n copies as numbers within -1 … 1, shape (n, m).

        Raises:
            ControlError: If the shape is wrong, or a number is NaN.
        """
        wanted = (n, len(self.names))
        axes = f" for {', '.join(self.names)}"
        try:
            given: NDArray[np.float64] = np.asarray(actions, dtype=np.float64)
        except (TypeError, ValueError):
            raise ControlError(
                f"an action must be numbers of shape {wanted}{axes}, got "
                f"{actions!r:.80}"
            ) from None
        if given.shape != wanted:
            raise ControlError(
                f"the action has shape {given.shape}; it must be {wanted}{axes}"
            )
        if np.count_nonzero(np.isnan(given)):
            i, k = np.argwhere(np.isnan(given))[0].tolist()
            raise ControlError(
                f"the action of copy {i} is NaN for '{self.names[k]}'; every number "
                "must be within -1 … 1"
            )
        return np.asarray(np.minimum(np.maximum(given, -1.0), 1.0))

    def of_arms(self, actions: Array) -> list[Array]:
        """Split checked actions by arm into arrays of shape (n, m)."""
        return [actions[:, part] for part in self._parts]


@final
class ArmActions:
    """The meaning of one arm's actions; the last number is for the arm's gripper."""

    def __init__(self, workspace: Workspace, options: EnvOptions) -> None:
        self._workspace = workspace
        self.mode = options.action
        prefix, axes = workspace.prefix, NAMES[options.action]
        self.names = (
            *([prefix + axis for axis in axes] or workspace.chain.joint_names),
            f"{prefix}gripper",
        )
        """Names of the numbers, such as joint or axis names."""
        period = options.period
        self.linear = LINEAR_SPEED * workspace.scale * period
        """Distance that the TCP moves in one control period at an action of 1 [m]."""
        self.turn = TURN_SPEED * period
        """Angle that the tool turns in one control period at an action of 1 [rad]."""
        self.joint = JOINT_SPEED * workspace.fastest * period
        """Angle that each joint moves in one control period at an action of 1 [rad],
        shape (6,)."""
        self.limit = FASTEST * workspace.fastest * period
        """Largest angle that each joint moves in one control period [rad], shape
        (6,)."""
        self._moves = np.array([*[self.linear] * 3, self.turn])
        self._lower, self._upper = workspace.lower + MARGIN, workspace.upper - MARGIN
        # Below this height, the fingertips would press on the table, so from there the
        # tool can only move up.
        self._lowest = workspace.lowest

    def openings(self, actions: Array) -> Array:
        """Return the gripper's openings [m], shape (n,), for actions from -1 to 1."""
        return (actions[:, -1] + 1.0) / 2.0 * self._workspace.gripper.max_opening

    def positions(self, actions: Array, target: Array, q: Array) -> Array:
        """Return the new targets of the joints [rad], shape (n, 6).

        Args:
            actions: Checked actions, shape (n, m).
            target: The current targets [rad], shape (n, 6).
            q: The measured positions [rad], shape (n, 6).
        """
        if self.mode == "joint":
            found = target + actions[:, :-1] * self.joint
        elif self.mode == "cartesian":
            moves = actions[:, :4] * self._moves
            tool = self._workspace.tool
            found = tool.steered(target, moves, self._lowest, self.limit)
        else:
            found = self.approach(target, self._tool_target(actions, target))
        # If a contact has pushed a joint beyond a limit, it is commanded to that limit.
        low = np.minimum(np.maximum(q - LEAD, self._lower), self._upper)
        high = np.maximum(np.minimum(q + LEAD, self._upper), self._lower)
        return np.asarray(np.minimum(np.maximum(found, low), high))

    def approach(self, target: Array, pose: Frames) -> Array:
        """Return joint targets [rad], (n, 6), one step closer to a pose of the tool."""
        return self._workspace.tool.approach(target, pose, self.limit)

    def _tool_target(self, actions: Array, target: Array) -> Frames:
        pose = self._workspace.tool.pose(target)
        position = pose.position + actions[:, :3] * self.linear
        return Frames(
            raised(position, pose.position, self._lowest),
            from_rotation_vectors(actions[:, 3:6] * self.turn) @ pose.rotation,
        )
