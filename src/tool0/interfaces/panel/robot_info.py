"""What a page is told of the robot at the start, from its description."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Literal, cast

from tool0.description.catalogue import RobotDescription, part_names
from tool0.description.model import Joint, JointLimits, JointType, RobotModel
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box, Cylinder, Geometry, Mesh, Sphere
from tool0.interfaces.panel.protocol import (
    GripperInfo,
    JointInfo,
    ObjectInfo,
    PartName,
    RobotInfo,
    ShapeInfo,
)
from tool0.interfaces.panel.robot_files import URDF_PATH, RobotFiles

ONE_AXIS = frozenset({JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC})


def robot_info(
    description: RobotDescription,
    joints: Sequence[str],
    ground: float | None,
    limits: Mapping[str, JointLimits],
) -> RobotInfo:
    """Return what a page needs to draw the robot.

    Args:
        description: The robot.
        joints: In the order of the arrays of every frame.
        ground: Its height in the robot's root [m].
        limits: Of joints whose limits are not those of the URDF.
    """
    model = description.model
    parts = [item for item in (description.arm, description.gripper) if item]
    return RobotInfo(
        name=model.name,
        title=" + ".join(parts) or description.source.name,
        root=model.root,
        urdf=URDF_PATH,
        ground=ground,
        joints=[
            _joint_info(model, model.joint(name), limits.get(name)) for name in joints
        ],
        grippers=[
            GripperInfo(
                name=gripper.name,
                joint=gripper.joint,
                max_opening=gripper.max_opening,
                min_speed=gripper.speed[0],
                max_speed=gripper.speed[1],
                min_force=gripper.force[0],
                max_force=gripper.force[1],
            )
            for gripper in model.grippers
        ],
        part_names={
            part: PartName(en=name.en, zh=name.zh)
            for part, name in part_names(description).items()
        },
    )


def object_info(item: SceneObject, files: RobotFiles) -> ObjectInfo:
    """Return what a page needs to draw an object of the scene."""
    return ObjectInfo(
        name=item.name,
        shape=_shape_info(item.geometry, files),
        rgba=item.rgba,
        mass=item.mass,
    )


def _joint_info(
    model: RobotModel, joint: Joint, limits: JointLimits | None
) -> JointInfo:
    limits = limits or joint.limits
    turns_on = joint.type is JointType.CONTINUOUS
    return JointInfo(
        name=joint.name,
        # Engines and the view have no joints of other types.
        type=cast(Literal["revolute", "continuous", "prismatic"], joint.type.value),
        lower=None if turns_on else _finite(limits.lower),
        upper=None if turns_on else _finite(limits.upper),
        velocity=_finite(limits.velocity),
        effort=_finite(limits.effort),
        driven=joint.name in model.transmission_by_joint,
        mimics=None if joint.mimic is None else joint.mimic.joint,
    )


def _shape_info(geometry: Geometry, files: RobotFiles) -> ShapeInfo:
    match geometry:
        case Box(size=size):
            return ShapeInfo(kind="box", size=size)
        case Cylinder(radius=radius, length=length):
            return ShapeInfo(kind="cylinder", radius=radius, length=length)
        case Sphere(radius=radius):
            return ShapeInfo(kind="sphere", radius=radius)
        case Mesh(scale=scale):
            return ShapeInfo(kind="mesh", size=scale, url=files.url(geometry))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
