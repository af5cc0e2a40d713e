"""Initial states of episodes in which the gripper holds the first object."""

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
"""Durations of the phases of a grasp [s]."""
SLIP: Final = 0.003
"""Largest distance that the object may slip between the pads during the lift [m]."""


def grasped(
    batch: Batch,
    item: SceneObject,
    *,
    space: Workspace,
    hold: Hold,
    force: float,
    start: Array,
) -> BatchState:
    """Grasp an object on the table, lift it, and return the resulting state.

    Args:
        batch: Batch of a single copy, which the caller closes.
        item: The object.
        space: Workspace of the arm that grasps the object and then rises to its start
            pose.
        hold: Way in which the gripper holds the object.
        force: Force at each pad [N].
        start: Positions of all joints at the start, when the grippers are open [rad |
            m], shape (n_joints,).

    Raises:
        ConfigError: If the gripper fails to hold the object.
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
    """Return an object's position in the frame of the tool [m], shape (3,)."""
    k = batch.object_names.index(item.name)
    return np.asarray(batch.object_position[0, k] - batch.tool_pose(space.arm)[0][0])
