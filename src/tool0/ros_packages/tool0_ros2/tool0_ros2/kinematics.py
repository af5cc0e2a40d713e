"""The frames of a robot's links, from its URDF."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from xml.etree import ElementTree

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""x, y, z, w."""

Pose = tuple[Vector3, Quaternion]
IDENTITY: Pose = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))

_TURNING = ("revolute", "continuous")


@dataclass(frozen=True)
class Joint:
    """A joint of the URDF: how its child link moves in its parent link."""

    name: str
    type: str
    parent: str
    child: str
    position: Vector3
    """Of the child in the parent at 0 [m]."""
    quat_xyzw: Quaternion
    axis: Vector3
    """Of unit length, in the child."""
    mimic: tuple[str, float, float] | None
    """The joint that it follows, the multiplier and the offset [rad | m]."""

    @property
    def is_movable(self) -> bool:
        return self.type in _TURNING or self.type == "prismatic"

    def transform(self, positions: Mapping[str, float]) -> tuple[Vector3, Quaternion]:
        """Return position and quaternion (xyzw) of the child in the parent.

        ``positions`` [rad | m] are by joint; absent ones are 0, or follow another.
        """
        q = self._position(positions)
        if q == 0.0:
            return self.position, self.quat_xyzw
        if self.type in _TURNING:
            s, c = math.sin(0.5 * q), math.cos(0.5 * q)
            x, y, z = self.axis
            return self.position, _product(self.quat_xyzw, (s * x, s * y, s * z, c))
        if self.type == "prismatic":
            x, y, z = self.axis
            dx, dy, dz = rotate(self.quat_xyzw, (q * x, q * y, q * z))
            px, py, pz = self.position
            return (px + dx, py + dy, pz + dz), self.quat_xyzw
        return self.position, self.quat_xyzw

    def _position(self, positions: Mapping[str, float]) -> float:
        if self.name in positions or self.mimic is None:
            return positions.get(self.name, 0.0)
        master, multiplier, offset = self.mimic
        return multiplier * positions.get(master, 0.0) + offset


def read_joints(urdf: str) -> list[Joint]:
    """Return every joint of a URDF document, in its order."""
    return [_joint(item) for item in ElementTree.fromstring(urdf).findall("joint")]


class LinkTree:
    """The links of a robot: where they are at given positions of its joints."""

    def __init__(self, urdf: str) -> None:
        joints = read_joints(urdf)
        self._above = {joint.child: joint for joint in joints}
        self.links = {link for joint in joints for link in (joint.parent, joint.child)}
        self.root = next(iter(self.links - self._above.keys()), "")
        """The link that no joint carries."""

    def pose(self, link: str, positions: Mapping[str, float]) -> Pose:
        """Return the pose of a link in the root; positions [rad | m] by joint."""
        pose = IDENTITY
        while (joint := self._above.get(link)) is not None:
            pose = compose(joint.transform(positions), pose)
            link = joint.parent
        return pose


def movable(joints: Iterable[Joint]) -> list[Joint]:
    """Return the joints that can move."""
    return [joint for joint in joints if joint.is_movable]


def _joint(element: ElementTree.Element) -> Joint:
    origin, axis = element.find("origin"), element.find("axis")
    mimic = element.find("mimic")
    x, y, z = _numbers(axis, "xyz", (1.0, 0.0, 0.0))
    length = math.sqrt(x * x + y * y + z * z) or 1.0
    return Joint(
        name=element.get("name", ""),
        type=element.get("type", ""),
        parent=_link(element, "parent"),
        child=_link(element, "child"),
        position=_numbers(origin, "xyz", (0.0, 0.0, 0.0)),
        quat_xyzw=from_rpy(*_numbers(origin, "rpy", (0.0, 0.0, 0.0))),
        axis=(x / length, y / length, z / length),
        mimic=None
        if mimic is None
        else (
            mimic.get("joint", ""),
            float(mimic.get("multiplier", 1.0)),
            float(mimic.get("offset", 0.0)),
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


def from_rpy(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the quaternion (xyzw) of fixed-axis angles [rad]."""
    sr, cr = math.sin(0.5 * roll), math.cos(0.5 * roll)
    sp, cp = math.sin(0.5 * pitch), math.cos(0.5 * pitch)
    sy, cy = math.sin(0.5 * yaw), math.cos(0.5 * yaw)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def compose(outer: Pose, inner: Pose) -> Pose:
    """Return the pose ``inner``, given in ``outer``, in the frame of ``outer``."""
    (px, py, pz), turn = outer
    x, y, z = rotate(turn, inner[0])
    return (px + x, py + y, pz + z), _product(turn, inner[1])


def inverse(pose: Pose) -> Pose:
    """Return the pose of the parent frame in ``pose``."""
    (x, y, z), (qx, qy, qz, qw) = pose
    turn = (-qx, -qy, -qz, qw)
    return rotate(turn, (-x, -y, -z)), turn


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def rotate(q: Quaternion, v: Vector3) -> Vector3:
    """Return a vector, given in the axes of a frame, in those of its parent."""
    x, y, z, w = q
    back = (-x, -y, -z, w)
    rx, ry, rz, _ = _product(_product(q, (*v, 0.0)), back)
    return rx, ry, rz
