"""The frames of a robot's links, computed from the robot's URDF."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree import ElementTree

from tool0_ros2.copied import (
    JointType,
    Mimic,
    Pose,
    Transform,
    Vector3,
    joint_transform,
)

_MOVABLE = (JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC)


@dataclass(frozen=True)
class Joint:
    """A joint in the URDF, which moves a child link relative to a parent link."""

    name: str
    type: JointType
    parent: str
    child: str
    origin: Pose
    """Pose of the child link in the parent link when the joint is at 0."""
    axis: Vector3
    """Axis of the joint in the frame of the child link, as a unit vector."""
    mimic: Mimic | None

    @property
    def is_movable(self) -> bool:
        return self.type in _MOVABLE


def read_joints(urdf: str) -> list[Joint]:
    """Return the joints of a URDF document, in document order."""
    return [_joint(item) for item in ElementTree.fromstring(urdf).findall("joint")]


class LinkTree:
    """The links of a robot, and their poses at given joint positions."""

    def __init__(self, urdf: str) -> None:
        joints = read_joints(urdf)
        self._above = {joint.child: joint for joint in joints}
        self.links = {link for joint in joints for link in (joint.parent, joint.child)}
        self.root = next(iter(self.links - self._above.keys()), "")
        """The root link, which is not the child of a joint."""

    def pose(self, link: str, positions: Mapping[str, float]) -> Transform:
        """Return the pose of a link in the root's frame.

        ``positions`` are the joint positions [rad | m], by joint name.
        """
        pose = Transform()
        while (joint := self._above.get(link)) is not None:
            pose = joint_transform(joint, positions) @ pose
            link = joint.parent
        return pose


def _joint(element: ElementTree.Element) -> Joint:
    origin, axis = element.find("origin"), element.find("axis")
    mimic = element.find("mimic")
    x, y, z = _numbers(axis, "xyz", (1.0, 0.0, 0.0))
    length = math.hypot(x, y, z) or 1.0
    return Joint(
        name=element.get("name", ""),
        type=JointType(element.get("type")),
        parent=_link(element, "parent"),
        child=_link(element, "child"),
        origin=Pose(
            xyz=_numbers(origin, "xyz", (0.0, 0.0, 0.0)),
            rpy=_numbers(origin, "rpy", (0.0, 0.0, 0.0)),
        ),
        axis=(x / length, y / length, z / length),
        mimic=None
        if mimic is None
        else Mimic(
            joint=mimic.get("joint", ""),
            multiplier=float(mimic.get("multiplier", 1.0)),
            offset=float(mimic.get("offset", 0.0)),
        ),
    )


def _link(element: ElementTree.Element, end: str) -> str:
    found = element.find(end)
    return "" if found is None else found.get("link", "")


def _numbers(
    element: ElementTree.Element | None, key: str, default: Vector3
) -> Vector3:
    text = None if element is None else element.get(key)
    if text is None:
        return default
    x, y, z = map(float, text.split())
    return x, y, z
