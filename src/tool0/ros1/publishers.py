"""Publishers that run for every snapshot: wrenches, images and frames of links."""

from __future__ import annotations

import logging
import os
import threading
from collections.abc import Iterable, Mapping
from typing import Any, final

from geometry_msgs.msg import Vector3, Wrench, WrenchStamped
from sensor_msgs.msg import CameraInfo, Image
from std_srvs.srv import Trigger, TriggerResponse
from tf2_msgs.msg import TFMessage

from tool0.api.robot import Robot
from tool0.api.sensors import CameraHandle, ForceTorque
from tool0.control.publish_rate import PublishRate
from tool0.description.forward_kinematics import joint_transform
from tool0.description.model import FLANGE, Joint
from tool0.description.parts import flange_names
from tool0.description.transform import Transform
from tool0.errors import NotOfferedError, Tool0Error
from tool0.installation.child_process import ChildProcess
from tool0.installation.ros1.library import find_node
from tool0.protocol.sensors import WrenchReading
from tool0.protocol.state import Snapshot
from tool0.ros1.messages import Message, transform_message
from tool0.ros1.namespace import RosNamespace
from tool0.ros1.node import SnapshotPublisher, WorkerThread

logger = logging.getLogger(__name__)


def sensor_publishers(
    ros: RosNamespace, robot: Robot, renderer: WorkerThread
) -> list[SnapshotPublisher]:
    """Return publishers for the cameras and for the wrench at each ``…tool0`` link."""
    cameras = [
        CameraPublisher(ros, robot.cameras[full], own, frame, renderer)
        for full, (own, frame) in camera_frames(ros, robot).items()
    ]
    flanges = {
        name: link
        for name, link in flange_names(robot.description.model).items()
        if ros.owns(link)
    }
    try:
        sensors = {name: robot.force_torque_of(link) for name, link in flanges.items()}
    except NotOfferedError as error:  # a real robot does not offer this
        logger.warning("no topic 'wrench': %s", error)
        return [*cameras]
    wrenches = [
        WrenchPublisher(
            ros,
            sensor,
            "" if len(flanges) == 1 or flanges[name] == FLANGE else f"{name}_",
        )
        for name, sensor in sensors.items()
    ]
    return [*cameras, *wrenches]


@final
class WrenchPublisher:
    """Topic ``wrench`` and a service that tares the sensor, named as in UR's driver.

    If there are several sensors, the names of the topic and the service start with a
    ``prefix``.  The first subscriber starts the sensor.  The sensor continues without
    subscribers, because stopping it would discard the tare.
    """

    def __init__(self, ros: RosNamespace, sensor: ForceTorque, prefix: str) -> None:
        self._ros, self._sensor = ros, sensor
        self._publisher = ros.publisher(
            f"{prefix}wrench", WrenchStamped, queue_size=100
        )
        self._service = ros.service(
            f"{prefix}ur_hardware_interface/zero_ftsensor", Trigger, self._tare
        )
        self._last: int | None = None  # number of the last sample that was published

    def publish(self, snapshot: Snapshot) -> None:
        """If there are subscribers, publish filtered samples since the last call."""
        if not self._publisher.get_num_connections():
            self._last = None
            return
        if self._last is None:
            self._last = self._sensor.read().number - 1
        for reading in self._sensor.samples(self._last):
            self._last = reading.number
            self._publisher.publish(self._message(reading))

    def close(self) -> None:
        self._service.shutdown()
        self._publisher.unregister()

    def _message(self, reading: WrenchReading) -> Message:
        return WrenchStamped(
            self._ros.header(reading.time, self._ros.frame(reading.frame)),
            Wrench(Vector3(*reading.force), Vector3(*reading.torque)),
        )

    def _tare(self, request: Message) -> Message:
        self._sensor.zero()
        return TriggerResponse(success=True, message="the sensor is tared")


def camera_frames(ros: RosNamespace, robot: Robot) -> dict[str, tuple[str, str]]:
    """Return each camera's own name and its optical frame, by the full name."""
    cameras = (handle.camera for handle in robot.cameras.values())
    description = robot.description
    prefix = description.prefix if description.cell is None else ""
    return {
        full: (own, ros.own_frame(f"{prefix}{own}_camera_color_optical_frame"))
        for full, own in ros.camera_names(cameras).items()
    }


def camera_transforms(ros: RosNamespace, robot: Robot) -> list[Message]:
    """Return each camera's pose on its link as a geometry_msgs/TransformStamped."""
    root = robot.description.model.root
    found = []
    for full, (_, frame) in camera_frames(ros, robot).items():
        camera = robot.cameras[full].camera
        header = ros.header(robot.time, ros.frame(camera.link or root))
        found.append(transform_message(header, frame, camera.T_link_camera))
    return found


@final
class CameraPublisher:
    """Topics ``image_raw`` and ``camera_info`` for the color and depth of a camera.

    Color and depth are parts of one image.  Color and depth therefore share the optical
    frame of the color image.
    """

    def __init__(
        self,
        ros: RosNamespace,
        handle: CameraHandle,
        name: str,
        frame: str,
        renderer: WorkerThread,
    ) -> None:
        self._ros, self._handle, self._renderer = ros, handle, renderer
        self._name, self._frame = name, frame
        self._rate = PublishRate(ros.node.options.camera_rate)
        # set while no image of this camera is being rendered
        self._is_idle = threading.Event()
        self._is_idle.set()
        self._colors = ros.publisher(f"{name}_camera/color/image_raw", Image)
        self._depths = ros.publisher(f"{name}_camera/depth/image_raw", Image)
        self._infos = [
            ros.publisher(f"{name}_camera/{kind}/camera_info", CameraInfo)
            for kind in ("color", "depth")
        ]

    def publish(self, snapshot: Snapshot) -> None:
        """Publish subscribed topics that are due, without waiting for an image.

        An image is skipped if the previous image is still being rendered.
        """
        if not self._rate.is_due(snapshot.time):
            return
        images = [self._colors, self._depths]
        if not any(publisher.get_num_connections() for publisher in images):
            self._publish_infos(snapshot.time)
        elif self._is_idle.is_set():
            self._is_idle.clear()
            self._renderer.submit(lambda: self._render(snapshot))

    def close(self) -> None:
        """Unregister the topics after the image in progress is published."""
        self._renderer.close()
        for publisher in (self._colors, self._depths, *self._infos):
            publisher.unregister()

    def _render(self, snapshot: Snapshot) -> None:
        try:
            image = self._handle.image(snapshot)
        except Tool0Error as error:
            self._ros.log_error(f"camera '{self._name}'", error)
            return
        finally:
            self._is_idle.set()
        if self._colors.get_num_connections():
            self._colors.publish(self._image(image.time, "rgb8", image.rgb))
        if self._depths.get_num_connections():
            depth = image.depth.astype("<f4", copy=False)
            self._depths.publish(self._image(image.time, "32FC1", depth))
        self._publish_infos(image.time)

    def _publish_infos(self, time: float) -> None:
        for publisher in self._infos:
            if publisher.get_num_connections():
                publisher.publish(self._camera_info(time))

    def _image(self, time: float, encoding: str, pixels: Any) -> Message:
        height, width = pixels.shape[:2]
        return Image(
            header=self._ros.header(time, self._frame),
            height=height,
            width=width,
            encoding=encoding,
            is_bigendian=0,
            step=pixels.nbytes // height,
            data=pixels.tobytes(),
        )

    def _camera_info(self, time: float) -> Message:
        camera = self._handle.camera
        K = camera.intrinsics
        return CameraInfo(
            header=self._ros.header(time, self._frame),
            height=camera.height,
            width=camera.width,
            distortion_model="plumb_bob",  # the coefficients mean no distortion
            D=[0.0] * 5,
            K=K.ravel().tolist(),
            R=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            P=[*K[0], 0.0, *K[1], 0.0, *K[2], 0.0],
        )


@final
class StaticFrames:
    """Topic ``/tf_static`` with the fixed frames in all of this node's namespaces.

    A latched topic keeps only one message for later subscribers.  Each message on
    ``/tf_static`` therefore contains all frames.
    """

    def __init__(self, ros: RosNamespace) -> None:
        self._publisher = ros.publisher("/tf_static", TFMessage, latch=True)
        self._transforms: list[Message] = []

    def add(self, transforms: Iterable[Message]) -> None:
        """Publish additional transforms."""
        self._transforms += transforms
        self._publisher.publish(self._transforms)

    def close(self) -> None:
        """Unregister the topic."""
        self._publisher.unregister()


def fixed_frames(ros: RosNamespace, robot: Robot) -> list[Message]:
    """Return the transforms that robot_state_publisher does not publish.

    The result contains the transforms of the cameras and, in a cell, the transform from
    ``world`` to the robot's own root.
    """
    transforms = camera_transforms(ros, robot)
    if ros.is_of_cell:
        root = robot.description.model.root
        header = ros.header(robot.time, root)
        transforms.append(transform_message(header, ros.frame(root), Transform()))
    return transforms


NAME = "robot_state_publisher"
_CHECK_RATE = 1.0
"""Rate at which the child process is checked, in simulated time [Hz]."""
_GRACE = 5.0
"""Time limit for the child process to end before it is killed [wall s]."""


@final
class RobotStatePublisher:
    """Publisher of the frames of links and cameras in a namespace.

    robot_state_publisher runs as a child process.  If that program is not installed or
    has ended, tool0 computes and publishes the same frames.
    """

    def __init__(self, ros: RosNamespace, robot: Robot, static: StaticFrames) -> None:
        self._ros, self._robot, self._static = ros, robot, static
        self._rate = PublishRate(ros.node.options.tf_pub_rate)
        self._check_rate = PublishRate(_CHECK_RATE)
        self._publisher: Any = None
        self._program = find_node(f"{NAME}/{NAME}")
        self._child: ChildProcess | None = None
        if self._program is None:
            self._take_over()
        else:
            self._child = self._start()

    def publish(self, snapshot: Snapshot) -> None:
        """Publish the frames of movable joints if they are due.  Monitor the child."""
        child = self._child
        if child is None:
            if self._rate.is_due(snapshot.time):
                names, values = snapshot.joint_names, snapshot.position
                position = dict(zip(names, values, strict=True))
                movable = (joint for joint in self._ros.joints if joint.is_movable)
                self._publisher.publish(
                    self._transforms(movable, position, snapshot.time)
                )
        elif self._check_rate.is_due(snapshot.time) and child.exit_status is not None:
            logger.warning(
                "robot_state_publisher ended with status %d; tool0 publishes /tf "
                "from now on.  Its last output:\n%s",
                child.exit_status,
                child.last_output(),
            )
            self._child = None
            self._take_over()

    def register_again(self) -> None:
        """Restart the child, because roscpp nodes do not detect a new master."""
        if self._child is not None:
            old, self._child = self._child, self._start()
            old.close()

    def close(self) -> None:
        """End the child process, and unregister the topics."""
        if self._child is not None:
            self._child.close()
        if self._publisher is not None:
            self._publisher.unregister()

    def _start(self) -> ChildProcess:
        ros, node = self._ros, self._ros.node
        name, rate = ros.name(NAME), node.options.tf_pub_rate
        node.master.call("setParam", f"{name}/publish_frequency", rate)
        node.master.call("setParam", f"{name}/tf_prefix", ros.tf_prefix)
        environment = {**os.environ, "ROS_NAMESPACE": ros.root or "/"}
        command = [str(self._program), f"__name:={NAME}"]
        return ChildProcess(command, environment=environment, grace=_GRACE)

    def _take_over(self) -> None:
        """Publish the fixed frames, and start to publish the movable frames."""
        fixed = (joint for joint in self._ros.joints if not joint.is_movable)
        self._static.add(self._transforms(fixed, {}, self._robot.time))
        self._publisher = self._ros.publisher("/tf", TFMessage, queue_size=100)

    def _transforms(
        self, joints: Iterable[Joint], position: Mapping[str, float], time: float
    ) -> list[Message]:
        frame = self._ros.frame
        return [
            transform_message(
                self._ros.header(time, frame(joint.parent)),
                frame(joint.child),
                joint_transform(joint, position),
            )
            for joint in joints
        ]
