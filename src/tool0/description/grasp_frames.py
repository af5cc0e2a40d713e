"""Pads of a gripper, and the grasp frame between the pads."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tool0.description.forward_kinematics import link_poses
from tool0.description.model import ParallelGripper, RobotModel
from tool0.description.transform import Transform, from_matrix
from tool0.errors import ControlError

if TYPE_CHECKING:
    from tool0.description.transform_arrays import Array


def pad_links(model: RobotModel, gripper: ParallelGripper) -> tuple[str, str]:
    """Return the pads of ``gripper``, the links that have a ``<gazebo>`` surface.

    Raises:
        ControlError: If the gripper does not have exactly two pads.
    """
    base = model.joint(gripper.joint).parent
    pads = [name for name in model.links_from(base) if model.link(name).surface]
    if len(pads) != 2:
        raise ControlError(
            f"gripper '{gripper.name}' needs two links with a <gazebo> surface, its "
            f"pads; below '{base}' there are {len(pads)}"
        )
    return pads[0], pads[1]


def flange_of(model: RobotModel, gripper: ParallelGripper) -> str:
    """Return the link that carries ``gripper``: a link ``…tool0``, or the base link."""
    base = link = model.joint(gripper.joint).parent
    while (joint := model.parent_joint.get(link)) and not joint.is_movable:
        link = joint.parent
        if link.endswith("tool0"):
            return link
    return base


def grasp_frame(
    model: RobotModel, gripper: ParallelGripper, opening: float, relative_to: str
) -> Transform:
    """Return the frame midway between the pads, in the link ``relative_to``.

    The y axis points from one pad to the other pad, and the z axis points away from the
    gripper's base.  If the pads move on circles, their distance from the base depends
    on the opening.  For a 2F-85, this distance changes by up to 14 mm.

    Args:
        model: The robot.
        gripper: One of the robot's grippers.
        opening: Distance between the pads [m].
        relative_to: A link to which the gripper is fixed, such as ``tool0``.

    Raises:
        ModelError: If the robot has no link ``relative_to``, or the opening is outside
            the gripper's range.
        ControlError: If the gripper does not have two pads.
    """
    import numpy as np  # NumPy is slow to import

    found = link_poses(model, {gripper.joint: gripper.position(opening)})
    base = model.joint(gripper.joint).parent
    T_tool_root = found[model.link(relative_to).name].inverse()
    p_base, p_first, p_second = (
        np.array((T_tool_root @ found[link]).position)
        for link in (base, *pad_links(model, gripper))
    )
    frame = np.eye(4)
    frame[:3, 3], frame[:3, :3] = frame_between(p_base, p_first, p_second)
    return from_matrix(frame)


def frame_between(
    p_base: Array, p_first: Array, p_second: Array
) -> tuple[Array, Array]:
    """Return position [m], (…, 3), and rotation, (…, 3, 3), of the frame between pads.

    The arguments are the positions of the gripper's base and of its pads [m], (…, 3).
    """
    import numpy as np  # slow to import

    def dot(u: Array, v: Array) -> Array:
        product: Array = u[..., None, :] @ v[..., :, None]
        return product[..., 0]

    middle = (p_first + p_second) / 2.0
    y = p_second - p_first
    y /= np.sqrt(dot(y, y))
    away = middle - p_base
    z = away - dot(away, y) * y
    z /= np.sqrt(dot(z, z))
    return middle, np.stack([np.cross(y, z), y, z], axis=-1)
