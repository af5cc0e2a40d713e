"""ROS names of the robot, or of one robot of a cell: topics, joints, frames."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, final

from rospy import Publisher, Service, ServiceException, Subscriber
from std_msgs.msg import Header

from tool0.description.config import CellRobot
from tool0.description.loading import load_description
from tool0.errors import Tool0Error

if TYPE_CHECKING:
    from tool0.api.robot import Robot
    from tool0.description.camera import Camera
    from tool0.ros1.node import RosNode

_JOINT_LIMITS = "joint_limits"
"""The YAML entry that contains limits by joint and is not a controller."""


@final
class RosNamespace:
    """A ROS namespace that contains the whole robot, or one robot of a cell.

    In its own namespace, a robot of a cell has the names that it has outside of a cell:
    the model's ``left_elbow_joint`` is ``elbow_joint`` in ``/left``, and ``left_tool0``
    is the frame ``left/tool0``.  This class translates all names: *full* names are the
    model's names, and *own* names are the names in ROS.  Without such a namespace, they
    are the same.
    """

    def __init__(
        self,
        node: RosNode,
        robot: Robot,
        *,
        urdf: str | None,
        name: str = "",
        tf_prefix: str = "",
    ) -> None:
        """Create a namespace of a node, with the robot of the bring-up or a part of it.

        Args:
            node: The node of the process.
            robot: The robot, with its cell, which knows the prefixes of all robots.
            urdf: URDF of the namespace's robot, with own names; None for the namespace
                of things that belong to no single robot of a cell.
            name: The robot's name in a cell if the robot has its own namespace.
            tf_prefix: Prefix of every frame.
        """
        self.node = node
        self.urdf = urdf
        self.root = f"{node.options.root}/{name}" if name else node.options.root
        """The namespace as the beginning of a name, such as ``""`` or ``/robot1``."""
        self.tf_prefix = tf_prefix.strip("/")
        """Prefix of every frame, without slashes around it."""
        self._prefix = prefix = f"{name}_" if name else ""
        cell = robot.description.cell
        robots = cell.robots if cell is not None and cell.namespaces else ()
        self._longer = tuple(
            other.prefix
            for other in robots
            if other.prefix != prefix and other.prefix.startswith(prefix)
        )
        model = robot.description.model
        self.joints = tuple(joint for joint in model.joints if self.owns(joint.name))
        """The model's joints that are in the namespace."""
        self._own_joints = {
            joint.name: self.to_ros(joint.name) for joint in self.joints
        }
        self._in_text = re.compile(rf"(?<!\w){re.escape(prefix)}(?=\w)")

    @property
    def has_robot(self) -> bool:
        """Whether the namespace contains a robot."""
        return self.urdf is not None

    def has_controllers(self, names: Iterable[str]) -> bool:
        """Return whether the namespace contains a robot or one of these controllers."""
        return self.has_robot or any(map(self.owns, names))

    @property
    def is_of_cell(self) -> bool:
        """Whether the namespace is for one robot of a cell, with translated names."""
        return bool(self._prefix)

    # ---- the names of joints, links and controllers ----------------------------------

    def owns(self, full: str) -> bool:
        """Return whether the item with this full name is in the namespace."""
        return full.startswith(self._prefix) and not full.startswith(self._longer)

    def to_ros(self, full: str) -> str:
        """Return the own name for a full name; other robots' names do not change."""
        return full.removeprefix(self._prefix) if self.owns(full) else full

    def to_model(self, own: str) -> str:
        """Return the full name for an own name."""
        return self._prefix + own

    def text(self, text: object) -> str:
        """Return a message with own names in place of full names."""
        return self._in_text.sub("", str(text)) if self._prefix else str(text)

    def own_parameters(self, yaml: Mapping[str, Any]) -> dict[str, Any]:
        """Return the part of the controllers' YAML that belongs to the namespace."""
        if not self._prefix:
            return {name: value for name, value in yaml.items() if self.owns(name)}
        found = {
            self.to_ros(name): _renamed(value, self._own_joints)
            for name, value in yaml.items()
            if self.owns(name)
        }
        limits = yaml.get(_JOINT_LIMITS)
        if isinstance(limits, dict):
            found[_JOINT_LIMITS] = {
                self.to_ros(joint): value
                for joint, value in limits.items()
                if joint in self._own_joints
            }
        return found

    def full_parameters(self, controller: Mapping[str, Any]) -> Any:
        """Return a controller's parameters with the full names of joints."""
        return _renamed(controller, {own: j for j, own in self._own_joints.items()})

    # ---- frames and cameras ----------------------------------------------------------

    def frame(self, link: str) -> str:
        """Return the frame of a link by its full name."""
        return self.own_frame(self.to_ros(link))

    def own_frame(self, own: str) -> str:
        """Return the frame with an own name, with ``tf_prefix``."""
        return f"{self.tf_prefix}/{own}" if self.tf_prefix else own

    def camera_names(self, cameras: Iterable[Camera]) -> dict[str, str]:
        """Return the cameras in the namespace: full name → own name.

        A camera without a link belongs to no single robot of a cell.  A camera keeps
        its full name if another camera already has its own name.
        """
        full = [item.name for item in cameras if self.owns(item.link or "")]
        own = {name: self.to_ros(name) for name in full}
        return {name: name if short in full else short for name, short in own.items()}

    # ---- topics and services ---------------------------------------------------------

    def name(self, relative: str) -> str:
        """Return the full ROS name; a name with a leading slash is already absolute."""
        return relative if relative[:1] == "/" else f"{self.root}/{relative}"

    def header(self, time: float, frame_id: str = "") -> Any:
        """Return a std_msgs/Header with simulated ``time`` [s]."""
        return Header(stamp=self.node.clock.to_ros(time), frame_id=frame_id)

    def publisher(
        self, name: str, kind: Any, *, queue_size: int = 1, latch: bool = False
    ) -> Any:
        """Return a rospy.Publisher whose slow subscribers do not delay others."""
        return Publisher(self.name(name), kind, queue_size=queue_size, latch=latch)

    def subscriber(self, name: str, kind: Any, callback: Callable[[Any], None]) -> Any:
        """Return a rospy.Subscriber that logs a Tool0Error from ``callback``."""
        full = self.name(name)

        def receive(message: Any) -> None:
            try:
                callback(message)
            except Tool0Error as error:
                self.log_error(full, error)

        return Subscriber(full, kind, receive, queue_size=1)

    def service(self, name: str, kind: Any, handler: Callable[[Any], Any]) -> Any:
        """Return a rospy.Service that logs a Tool0Error and lets the call fail."""
        full = self.name(name)

        def answer(request: Any) -> Any:
            try:
                return handler(request)
            except Tool0Error as error:
                self.log_error(full, error)
                raise ServiceException(self.text(error)) from None

        return Service(full, kind, answer)

    def log_error(self, where: str, error: Tool0Error) -> None:
        """Log an error that occurred at ``where``, also on /rosout."""
        self.node.log_error(f"{where}: {self.text(error)}")


def namespaces_of(node: RosNode, robot: Robot) -> list[RosNamespace]:
    """Return the root namespace and, in a cell with namespaces, one for each robot.

    In such a cell, each robot's namespace has the URDF of that robot alone.
    """
    cell = robot.description.cell
    if cell is None or not cell.namespaces:
        whole = robot.description
        tf_prefix = whole.tf_prefix
        return [RosNamespace(node, robot, urdf=whole.urdf, tf_prefix=tf_prefix)]

    def urdf_of(item: CellRobot) -> str:
        return load_description(item.description, spawn_z=robot.info.spawn_z).urdf

    return [
        RosNamespace(node, robot, urdf=None),
        *(
            RosNamespace(
                node, robot, urdf=urdf_of(item), name=item.name, tf_prefix=item.name
            )
            for item in cell.robots
        ),
    ]


def _renamed(value: Any, names: Mapping[str, str]) -> Any:
    """Return plain YAML values with names replaced in keys and texts."""
    match value:
        case dict():
            return {names.get(k, k): _renamed(v, names) for k, v in value.items()}
        case list():
            return [_renamed(item, names) for item in value]
        case str():
            return names.get(value, value)
    return value
