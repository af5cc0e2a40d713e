"""The arms in n copies of a task, with their targets and measurements."""

from __future__ import annotations

from typing import final

import numpy as np

from tool0.batch.batch import Batch
from tool0.gym.actions import ArmActions
from tool0.gym.bounds import columns, reading
from tool0.gym.options import EnvOptions
from tool0.gym.task import ArmState, Mask
from tool0.gym.workspace import Workspace
from tool0.kinematics.chain import Array

GRIP_FORCE = 60.0
"""Grip force at each pad [N], clamped to the force range of the gripper."""
DEADBAND = 0.02
"""Smallest change of a gripper's target that is commanded, as a fraction of the
stroke."""


@final
class ArmCopies:
    """One arm with its gripper in the copies of a batch."""

    def __init__(
        self, batch: Batch, space: Workspace, options: EnvOptions, *, has_wrench: bool
    ) -> None:
        """Use the arm of a workspace.

        ``has_wrench`` adds the wrench on the arm's tool to the measurements.
        """
        self.space, self.actions = space, ArmActions(space, options)
        self._batch, self._has_wrench = batch, has_wrench
        self._period = options.period
        names, gripper = batch.joint_names, space.gripper
        self._joints = columns([names.index(x) for x in space.chain.joint_names])
        self._drive = names.index(gripper.joint)
        self.force = min(max(GRIP_FORCE, gripper.force[0]), gripper.force[1])
        """Force of the arm's gripper at each pad [N]."""
        self.target = np.tile(space.start, (batch.n, 1))
        """Targets of the arm's joints [rad], shape (n, 6)."""
        self._opening_target = np.full(batch.n, gripper.max_opening)
        self._last_opening = self._opening_target.copy()

    def copy_from(self, other: ArmCopies) -> None:
        """Copy the targets from the same arm in other copies."""
        self.target = other.target.copy()
        self._opening_target = other._opening_target.copy()
        self._last_opening = other._last_opening.copy()

    def put(self, position: Array, q: Array) -> None:
        """Write ``q`` [rad] and the position of an open gripper into ``position``.

        ``q`` has the shape (…, 6), and ``position`` has the shape (…, k).
        """
        position[..., self._joints] = q
        position[..., self._drive] = self.space.gripper.position(
            self.space.gripper.max_opening
        )

    def restart(self, which: Mask, q: Array, is_held: Mask) -> None:
        """Start episodes of copies with joint targets ``q`` [rad], (n, 6).

        The grippers start open, except in the copies in ``is_held``, where they start
        closed.
        """
        self._opening_target[which] = self.space.gripper.max_opening
        self._opening_target[is_held] = 0.0
        self.target[which] = q[which]

    def settle(self, which: Mask) -> None:
        """Store the current openings as those before the first action."""
        opening = self._batch.opening(self.space.gripper_name)
        self._last_opening[which] = opening[which]

    def move(self, q: Array, duration: float, which: Mask) -> None:
        """Move copies to rest at ``q`` [rad], shape (n, 6)."""
        self._batch.command(
            q,
            velocities=0.0 * q,
            duration=duration,
            joints=self.space.chain.joint_names,
            which=which,
        )

    def act(self, actions: Array, opening: Array) -> None:
        """Command checked ``actions``, shape (n, m), for one control period.

        ``opening`` is the measured opening [m], shape (n,).
        """
        batch = self._batch
        q = batch.position[:, self._joints]
        which = None
        if np.count_nonzero(batch.diverged):
            which = np.isfinite(q).all(axis=1) & ~batch.diverged
        self._last_opening = opening
        moved = self.actions.positions(actions, self.target, q)
        if which is not None:
            moved = np.where(which[:, None], moved, self.target)
        self.target = moved
        batch.command(
            self.target,
            duration=self._period,
            joints=self.space.chain.joint_names,
            which=which,
        )
        widest = self.space.gripper.max_opening
        openings = self.actions.openings(actions)
        is_new = np.abs(openings - self._opening_target) > DEADBAND * widest
        if np.count_nonzero(is_new):
            self._opening_target = np.where(is_new, openings, self._opening_target)
            batch.move_gripper(
                self._opening_target,
                force=self.force,
                gripper=self.space.gripper_name,
                which=is_new,
            )

    def measure(self) -> ArmState:
        """Return the current measurements of the arm and its gripper."""
        batch = self._batch
        read = reading(batch.diverged)
        q = read(batch.position[:, self._joints])
        pose = self.space.tool.pose(q)
        opening = read(batch.opening(self.space.gripper_name))
        return ArmState(
            q=q,
            qd=read(batch.velocity[:, self._joints]),
            tcp_position=pose.position,
            tcp_rotation=pose.rotation,
            opening=opening,
            opening_rate=(opening - self._last_opening) / self._period,
            opening_target=self._opening_target.copy(),
            wrench=self._wrench(),
        )

    def _wrench(self) -> Array:
        if not self._has_wrench:
            return np.empty((self._batch.n, 0))
        return reading(self._batch.diverged)(self._batch.tool_wrench(self.space.arm))
