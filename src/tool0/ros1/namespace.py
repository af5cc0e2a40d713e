"""ROS names of the robot, or of one robot of a cell: topics, joints and frames."""

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
"""Name of the YAML entry that contains joint limits and is not a controller."""


@final
class RosNamespace:
    """A ROS namespace that contains the whole robot, or one robot of a cell.

    In its own namespace, a robot of a cell has the same names as outside a cell.  For
    example, the model's ``left_elbow_joint`` is ``elbow_joint`` in ``/left``, and
    ``left_tool0`` is the frame ``left/tool0``.  The class RosNamespace translates all
    names.  *Full* names are the model's names, and *own* names are the names in ROS.
    If a robot has no namespace of its own, its full names and own names are the same.
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
        """Create a namespace of a node, for all robots of the bring-up or for one.

        Args:
            node: The node of the process.
            robot: The robot of the bring-up, which provides the prefixes of all robots
                of the cell.
            urdf: URDF of the namespace's robot, with own names.  The URDF is None for
                the namespace of items that are not part of a single robot of a cell.
            name: The robot's name in a cell, if the robot has its own namespace.
            tf_prefix: Prefix of every frame.
        """
        self.node = node
        self.urdf = urdf
        self.root = f"{node.options.root}/{name}" if name else node.options.root
        """The namespace as the beginning of a name, such as ``""`` or ``/robot1``."""
        self.tf_prefix = tf_prefix.strip("/")
        """Prefix of every frame, without leading and trailing slashes."""
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
        """Whether the namespace contains a robot."""
        return self.urdf is not None

    def has_controllers(self, names: Iterable[str]) -> bool:
        """Return whether the namespace contains a robot or one of the controllers."""
        return self.has_robot or any(map(self.owns, names))

    @property
    def is_of_cell(self) -> bool:
        """Whether the namespace is for one robot of a cell, with translated names."""
        return bool(self._prefix)

    # ---- the names of joints, links and controllers ----------------------------------

    def owns(self, full: str) -> bool:
        """Return whether the namespace contains the item with this full name."""
        return full.startswith(self._prefix) and not full.startswith(self._longer)

    def to_ros(self, full: str) -> str:
        """Return the own name for a full name.  Names of other robots do not change."""
        return full.removeprefix(self._prefix) if self.owns(full) else full

    def to_model(self, own: str) -> str:
        """Return the full name for an own name."""
        return self._prefix + own

    def text(self, text: object) -> str:
        """Return a message in which full names are replaced by own names."""
        return self._in_text.sub("", str(text)) if self._prefix else str(text)

    def own_parameters(self, yaml: Mapping[str, Any]) -> dict[str, Any]:
        """Return the part of the controllers' YAML for this namespace."""
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
        """Return the frame of a link, which is given by its full name."""
        return self.own_frame(self.to_ros(link))

    def own_frame(self, own: str) -> str:
        """Return the frame with an own name.  The frame includes ``tf_prefix``."""
        return f"{self.tf_prefix}/{own}" if self.tf_prefix else own

    def camera_names(self, cameras: Iterable[Camera]) -> dict[str, str]:
        """Return the own name of each camera in the namespace, by full name.

        In a cell, a camera that is not on a link is in no robot's namespace.  A camera
        keeps its full name if another camera already has the same own name.
        """
        full = [item.name for item in cameras if self.owns(item.link or "")]
        own = {name: self.to_ros(name) for name in full}
        return {name: name if short in full else short for name, short in own.items()}

    # ---- topics and services ---------------------------------------------------------

    def name(self, relative: str) -> str:
        """Return the full ROS name.  A name with a leading slash does not change."""
        return relative if relative[:1] == "/" else f"{self.root}/{relative}"

    def header(self, time: float, frame_id: str = "") -> Any:
        """Return a std_msgs/Header with simulated ``time`` [s]."""
        return Header(stamp=self.node.clock.to_ros(time), frame_id=frame_id)

    def publisher(
        self, name: str, kind: Any, *, queue_size: int = 1, latch: bool = False
    ) -> Any:
        """Return a rospy.Publisher in which slow subscribers do not delay others."""
        return Publisher(self.name(name), kind, queue_size=queue_size, latch=latch)

    def subscriber(self, name: str, kind: Any, callback: Callable[[Any], None]) -> Any:
        """Return a rospy.Subscriber.

        The subscriber logs each Tool0Error that ``callback`` raises.
        """
        full = self.name(name)

        def receive(message: Any) -> None:
            try:
                callback(message)
            except Tool0Error as error:
                self.log_error(full, error)

        return Subscriber(full, kind, receive, queue_size=1)

    def service(self, name: str, kind: Any, handler: Callable[[Any], Any]) -> Any:
        """Return a rospy.Service.

        If ``handler`` raises a Tool0Error, the service logs it, and the call fails.
        """
        full = self.name(name)

        def answer(request: Any) -> Any:
            try:
                return handler(request)
            except Tool0Error as error:
                self.log_error(full, error)
                raise ServiceException(self.text(error)) from None

        return Service(full, kind, answer)

    def log_error(self, where: str, error: Tool0Error) -> None:
        """Log an error that occurred at ``where``, and publish it on /rosout."""
        self.node.log_error(f"{where}: {self.text(error)}")


def namespaces_of(node: RosNode, robot: Robot) -> list[RosNamespace]:
    """Return the root namespace.

    In a cell with namespaces, a namespace for each robot is also returned.

    In a cell with namespaces, each robot's namespace contains the URDF of that robot
    only.
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
    """Return plain YAML values in which names are replaced in keys and texts."""
    match value:
        case dict():
            return {names.get(k, k): _renamed(v, names) for k, v in value.items()}
        case list():
            return [_renamed(item, names) for item in value]
        case str():
            return names.get(value, value)
    return value
