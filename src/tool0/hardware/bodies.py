"""The robot as rigid bodies: fixed links merged into the movable link they ride on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from tool0.description.model import Inertial, Joint, JointType, RobotModel
from tool0.description.transform import pose_matrix
from tool0.errors import ModelError

Matrix = np.ndarray


@final
@dataclass(frozen=True, slots=True)
class BodyInertia:
    """Mass, centre of mass (3,) and inertia about it (3, 3), all in one frame."""

    mass: float
    center: Matrix
    tensor: Matrix

    @staticmethod
    def of(inertial: Inertial, frame: Matrix) -> BodyInertia:
        """Return ``inertial`` seen from the frame in which its link has ``frame``."""
        pose = frame @ pose_matrix(inertial.origin)
        i = inertial
        tensor = np.array(
            [[i.ixx, i.ixy, i.ixz], [i.ixy, i.iyy, i.iyz], [i.ixz, i.iyz, i.izz]]
        )
        rotation = pose[:3, :3]
        return BodyInertia(i.mass, pose[:3, 3], rotation @ tensor @ rotation.T)

    @staticmethod
    def total(parts: Sequence[BodyInertia]) -> BodyInertia:
        """Return the parts as one body (parallel-axis theorem)."""
        mass = sum(part.mass for part in parts)
        if mass == 0.0:
            return BodyInertia(0.0, np.zeros(3), np.zeros((3, 3)))
        center = sum((p.mass * p.center for p in parts), np.zeros(3)) / mass
        tensor = np.zeros((3, 3))
        for part in parts:
            offset = part.center - center
            tensor += part.tensor + part.mass * (
                offset @ offset * np.eye(3) - np.outer(offset, offset)
            )
        return BodyInertia(mass, center, tensor)


@final
@dataclass(frozen=True, slots=True)
class MovingBody:
    """A movable link with every link fixed to it."""

    joint: Joint
    parent: int
    """Index of the body that carries the joint; -1 is the world."""
    placement: Matrix
    """The joint's frame in its parent body's frame, shape (4, 4)."""
    links: tuple[tuple[str, Matrix], ...]
    """Links of the body with their frames in the body's frame."""
    inertia: BodyInertia
    """In the frame of the joint's child link."""


def moving_bodies(model: RobotModel) -> tuple[MovingBody, ...]:
    """Return the bodies that move, in the order of ``model.movable_joints``."""
    index = {joint.name: i for i, joint in enumerate(model.movable_joints)}
    bodies = []
    for joint in model.movable_joints:
        if joint.type in (JointType.FLOATING, JointType.PLANAR):
            raise ModelError(
                f"joint '{joint.name}' is {joint.type.value}, which is not supported; "
                "use revolute, continuous, prismatic or fixed joints"
            )
        placement, link = pose_matrix(joint.origin), joint.parent
        while (above := model.parent_joint.get(link)) and not above.is_movable:
            placement, link = pose_matrix(above.origin) @ placement, above.parent
        links = tuple(_fixed_links(model, joint.child, np.eye(4)))
        parts = [
            BodyInertia.of(inertial, frame)
            for name, frame in links
            if (inertial := model.link_by_name[name].inertial) is not None
        ]
        bodies.append(
            MovingBody(
                joint=joint,
                parent=index[above.name] if above else -1,
                placement=placement,
                links=links,
                inertia=BodyInertia.total(parts),
            )
        )
    return tuple(bodies)


def check_masses(model: RobotModel, bodies: Sequence[MovingBody]) -> None:
    """Raise ModelError if a body has no mass, which no physics can move."""
    for body in bodies:
        if not body.inertia.mass > 0.0:
            joint = body.joint
            raise ModelError(
                f"link '{joint.child}' moves with joint '{joint.name}' but has no "
                "mass; give it an <inertial>",
                model.locations.get(f"link:{joint.child}"),
            )


def fixed_to_world(model: RobotModel) -> tuple[tuple[str, Matrix], ...]:
    """Return the links that never move, with their frames in the world."""
    return tuple(_fixed_links(model, model.root, np.eye(4)))


def _fixed_links(
    model: RobotModel, link: str, frame: Matrix
) -> list[tuple[str, Matrix]]:
    found = [(link, frame)]
    for joint in model.child_joints[link]:
        if not joint.is_movable:
            below = frame @ pose_matrix(joint.origin)
            found.extend(_fixed_links(model, joint.child, below))
    return found
