"""Starts of episodes with the first object in the closed gripper."""

from __future__ import annotations

from typing import Final

import numpy as np

from tool0.batch.batch import Batch
from tool0.batch.saved import BatchState
from tool0.description.scene import SceneObject
from tool0.errors import ConfigError
from tool0.gym.hold import Hold
from tool0.gym.workspace import Workspace
from tool0.kinematics.chain import Array

CLOSING, RISING, SETTLING = 0.8, 1.0, 0.5
"""Duration of the parts of a grasp [s]."""
SLIP: Final = 0.003
"""Largest distance that the object slips between the pads meanwhile [m]."""


def grasped(
    batch: Batch,
    item: SceneObject,
    *,
    space: Workspace,
    hold: Hold,
    force: float,
    start: Array,
) -> BatchState:
    """Grasp an object on the table, lift it, and return the state of the only copy.

    Args:
        batch: One copy, to be closed by the caller.
        item: The object.
        space: The arm that grasps it, and which rises to its start.
        hold: How the pads hold it.
        force: At each pad [N].
        start: Positions of all joints at the start, grippers open, (n_joints,).

    Raises:
        ConfigError: If the gripper does not hold the object.
    """
    place = np.array([*space.start_position[:2], item.pose.xyz[2]])
    yaw = space.start_yaw
    quat = np.array([np.cos(yaw / 2.0), 0.0, 0.0, np.sin(yaw / 2.0)])
    joints = space.chain.joint_names
    low = start.copy()
    columns = [batch.joint_names.index(joint) for joint in joints]
    low[columns] = space.posture(hold.places(place[None], quat[None])[0])
    batch.reset(position=low)
    batch.place(item.name, place, quat)
    batch.run(SETTLING)
    batch.move_gripper(0.0, force=force, gripper=space.gripper_name)
    batch.run(CLOSING)
    before = _offset(batch, space, item)
    high = space.start
    batch.command(high, velocities=np.zeros_like(high), duration=RISING, joints=joints)
    batch.run(RISING + SETTLING)
    slip = float(np.linalg.norm(_offset(batch, space, item) - before))
    width = float(batch.opening(space.gripper_name)[0])
    if slip > SLIP or not np.isclose(width, hold.width, rtol=0.2):
        raise ConfigError(
            f"the gripper cannot hold '{item.name}': it slipped by {1000.0 * slip:.1f} "
            f"mm, and the pads are {width:.4f} m apart; Task.hold.width is "
            f"{hold.width} m"
        )
    return batch.save()


def _offset(batch: Batch, space: Workspace, item: SceneObject) -> Array:
    """Return where an object is relative to the tool [m], shape (3,)."""
    k = batch.object_names.index(item.name)
    return np.asarray(batch.object_position[0, k] - batch.tool_pose(space.arm)[0][0])
