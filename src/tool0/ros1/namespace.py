"""The names of the robot, or of one robot of a cell, in ROS: topics, joints, frames."""

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
"""The entry of the YAML that is no controller, but has limits by joint."""


@final
class RosNamespace:
    """A namespace in ROS, with the whole robot in it, or one robot of a cell.

    In a namespace of its own, a robot of a cell has the names that it has alone:
    ``left_elbow_joint`` of the model is ``elbow_joint`` in ``/left``, and
    ``left_tool0`` is the frame ``left/tool0``.  This class does all the translation:
    *full* names are those of the model, *own* names those in ROS.  Without such a
    namespace they are the same.
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
        """Take the node, the robot of the bring-up, and the contents of the namespace.

        Args:
            node: The node of the process.
            robot: The robot; its cell knows the prefixes of the others.
            urdf: Contents of the namespace, by its own names; None for what belongs to
                no single robot of a cell.
            name: The robot's name in a cell, if it has a namespace of its own.
            tf_prefix: Prefix of every frame.
        """
        self.node = node
        self.urdf = urdf
        self.root = f"{node.options.root}/{name}" if name else node.options.root
        """The namespace as the beginning of a name: ``""`` or ``/robot1``."""
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
        """The joints of the model that are in the namespace."""
        self._own_joints = {
            joint.name: self.to_ros(joint.name) for joint in self.joints
        }
        self._in_text = re.compile(rf"(?<!\w){re.escape(prefix)}(?=\w)")

    @property
    def has_robot(self) -> bool:
        """Whether there is a robot in it."""
        return self.urdf is not None

    def has_controllers(self, names: Iterable[str]) -> bool:
        """Return whether there is a robot, or one of these controllers by full name."""
        return self.has_robot or any(map(self.owns, names))

    @property
    def is_of_cell(self) -> bool:
        """Whether it has one robot of a cell, whose names are translated."""
        return bool(self._prefix)

    # ---- the names of joints, links and controllers ----------------------------------

    def owns(self, full: str) -> bool:
        """Return whether what has this full name is in the namespace."""
        return full.startswith(self._prefix) and not full.startswith(self._longer)

    def to_ros(self, full: str) -> str:
        """Return a name of the model as ROS has it; others' names do not change."""
        return full.removeprefix(self._prefix) if self.owns(full) else full

    def to_model(self, own: str) -> str:
        """Return a name in ROS as the model has it."""
        return self._prefix + own

    def text(self, text: object) -> str:
        """Return a message with ROS names."""
        return self._in_text.sub("", str(text)) if self._prefix else str(text)

    def own_parameters(self, yaml: Mapping[str, Any]) -> dict[str, Any]:
        """Return the part of the controllers' YAML that is in the namespace."""
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
        """Return the frame of the link with a full name."""
        return self.own_frame(self.to_ros(link))

    def own_frame(self, own: str) -> str:
        """Return the frame with an own name."""
        return f"{self.tf_prefix}/{own}" if self.tf_prefix else own

    def camera_names(self, cameras: Iterable[Camera]) -> dict[str, str]:
        """Return the own names of the cameras in the namespace, by full names.

        A camera without a link belongs to no single robot of a cell.  A camera keeps
        its full name if another one has the own one.
        """
        full = [item.name for item in cameras if self.owns(item.link or "")]
        own = {name: self.to_ros(name) for name in full}
        return {name: name if short in full else short for name, short in own.items()}

    # ---- topics and services ---------------------------------------------------------

    def name(self, relative: str) -> str:
        """Return a name in the namespace; a leading slash makes it absolute."""
        return relative if relative[:1] == "/" else f"{self.root}/{relative}"

    def header(self, time: float, frame_id: str = "") -> Any:
        """Return a std_msgs/Header with simulated ``time`` [s]."""
        return Header(stamp=self.node.clock.to_ros(time), frame_id=frame_id)

    def publisher(
        self, name: str, kind: Any, *, queue_size: int = 1, latch: bool = False
    ) -> Any:
        """Return a rospy.Publisher; a slow subscriber does not delay the others."""
        return Publisher(self.name(name), kind, queue_size=queue_size, latch=latch)

    def subscriber(self, name: str, kind: Any, callback: Callable[[Any], None]) -> Any:
        """Return a rospy.Subscriber; a Tool0Error of ``callback`` is logged."""
        full = self.name(name)

        def receive(message: Any) -> None:
            try:
                callback(message)
            except Tool0Error as error:
                self.log_error(full, error)

        return Subscriber(full, kind, receive, queue_size=1)

    def service(self, name: str, kind: Any, handler: Callable[[Any], Any]) -> Any:
        """Return a rospy.Service; a Tool0Error is logged and makes the call fail."""
        full = self.name(name)

        def answer(request: Any) -> Any:
            try:
                return handler(request)
            except Tool0Error as error:
                self.log_error(full, error)
                raise ServiceException(self.text(error)) from None

        return Service(full, kind, answer)

    def log_error(self, where: str, error: Tool0Error) -> None:
        """Log an error at ``where``, also on /rosout."""
        self.node.log_error(f"{where}: {self.text(error)}")


def namespaces_of(node: RosNode, robot: Robot) -> list[RosNamespace]:
    """Return the root with the whole robot, or the root and one for each robot.

    A robot of a cell with namespaces has the URDF of that robot alone.
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
    """Return plain values of YAML with other names in keys and texts."""
    match value:
        case dict():
            return {names.get(k, k): _renamed(v, names) for k, v in value.items()}
        case list():
            return [_renamed(item, names) for item in value]
        case str():
            return names.get(value, value)
    return value
