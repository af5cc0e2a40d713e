"""Starts of episodes with the first object in the closed gripper."""

from __future__ import annotations

from typing import Final

import numpy as np

from tool0.batch.batch import Batch
from tool0.batch.saved import BatchState
from tool0.errors import ConfigError
from tool0.gym.hold import Hold
from tool0.kinematics.chain import Array

CLOSING, RISING, SETTLING = 0.8, 1.0, 0.5
"""Duration of the parts of a grasp [s]."""
SLIP: Final = 0.003
"""Largest distance that the object slips between the pads meanwhile [m]."""


def grasped(
    batch: Batch,
    name: str,
    *,
    place: Array,
    yaw: float,
    hold: Hold,
    force: float,
    low: Array,
    high: Array,
) -> BatchState:
    """Grasp an object on the table, lift it, and return the state of the only copy.

    Args:
        batch: One copy, to be closed by the caller.
        name: The object.
        place: Where it stands [m], shape (3,).
        yaw: Of the object [rad].
        hold: How the pads hold it.
        force: At each pad [N].
        low: Positions of all joints around the object, gripper open, (n_joints,).
        high: Positions of the arm's joints after the lift [rad], shape (6,).

    Raises:
        ConfigError: If the gripper does not hold the object.
    """
    batch.reset(position=low)
    quat = np.array([np.cos(yaw / 2.0), 0.0, 0.0, np.sin(yaw / 2.0)])
    batch.place(name, place, quat)
    batch.run(SETTLING)
    batch.move_gripper(0.0, force=force)
    batch.run(CLOSING)
    before = _offset(batch, name)
    batch.command(high, velocities=np.zeros_like(high), duration=RISING)
    batch.run(RISING + SETTLING)
    slip = float(np.linalg.norm(_offset(batch, name) - before))
    width = float(batch.opening()[0])
    if slip > SLIP or not np.isclose(width, hold.width, rtol=0.2):
        raise ConfigError(
            f"the gripper cannot hold '{name}': it slipped by {1000.0 * slip:.1f} mm, "
            f"and the pads are {width:.4f} m apart; Task.hold.width is {hold.width} m"
        )
    return batch.save()


def _offset(batch: Batch, name: str) -> Array:
    """Return where an object is relative to the tool [m], shape (3,)."""
    k = batch.object_names.index(name)
    return np.asarray(batch.object_position[0, k] - batch.tool_pose()[0][0])
