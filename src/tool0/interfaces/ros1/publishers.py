"""Publishers of every snapshot: wrench, images, and the frames of links."""

from __future__ import annotations

import contextlib
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
from tool0.control.joint_state import PublishRate
from tool0.description.camera import Camera
from tool0.description.forward_kinematics import joint_transform
from tool0.description.model import Joint
from tool0.errors import ControlError, Tool0Error
from tool0.installation.child_process import ChildProcess
from tool0.installation.ros1.library import find_node
from tool0.interfaces.ros1.messages import Message, transform_message
from tool0.interfaces.ros1.node import RosNode, SnapshotPublisher, WorkerThread
from tool0.sensing.force_torque import WrenchReading
from tool0.sensing.snapshot import Snapshot

logger = logging.getLogger(__name__)


def sensor_publishers(node: RosNode, robot: Robot) -> list[SnapshotPublisher]:
    """Return publishers of the cameras and of the wrench at the only ``tool0``.

    A robot without ``tool0``, or with several, has no wrench.
    """
    renderer = WorkerThread("tool0 ros1 cameras")  # one for all
    publishers: list[SnapshotPublisher] = [
        CameraPublisher(
            node, handle, camera_frame(handle.camera, node, robot), renderer
        )
        for handle in robot.cameras.values()
    ]
    with contextlib.suppress(ControlError):
        publishers.append(WrenchPublisher(node, robot.force_torque))
    return publishers


@final
class WrenchPublisher:
    """``wrench``, and a service that tares it, named as in Universal Robots' driver.

    The first subscriber starts the sensor.  It continues without subscribers: stopping
    would lose the tare.
    """

    def __init__(self, node: RosNode, sensor: ForceTorque) -> None:
        self._node, self._sensor = node, sensor
        self._publisher = node.publisher("wrench", WrenchStamped, queue_size=100)
        self._service = node.service(
            "ur_hardware_interface/zero_ftsensor", Trigger, self._tare
        )
        self._last: int | None = None  # number of the last sample that was published

    def publish(self, snapshot: Snapshot) -> None:
        """Publish the filtered samples since the last call, if anyone subscribes."""
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
            self._node.header(reading.time, self._node.frame(reading.frame)),
            Wrench(Vector3(*reading.force), Vector3(*reading.torque)),
        )

    def _tare(self, request: Message) -> Message:
        self._sensor.zero()
        return TriggerResponse(success=True, message="the sensor is tared")


def camera_frame(camera: Camera, node: RosNode, robot: Robot) -> str:
    """Return the name of a camera's optical frame, with the prefixes of the links."""
    prefix = robot.description.prefix
    return node.frame(f"{prefix}{camera.name}_camera_color_optical_frame")


def camera_transforms(node: RosNode, robot: Robot) -> list[Message]:
    """Return the pose of each camera on its link: geometry_msgs/TransformStamped."""
    root = robot.description.model.root
    return [
        transform_message(
            node.header(robot.time, node.frame(camera.link or root)),
            camera_frame(camera, node, robot),
            camera.T_link_camera,
        )
        for camera in (handle.camera for handle in robot.cameras.values())
    ]


@final
class CameraPublisher:
    """``image_raw`` and ``camera_info`` of one camera's colours and depth.

    Both belong to one image, so they share the optical frame of the colours.
    """

    def __init__(
        self, node: RosNode, handle: CameraHandle, frame: str, renderer: WorkerThread
    ) -> None:
        self._node, self._handle, self._renderer = node, handle, renderer
        self._frame = frame
        self._rate = PublishRate(node.options.camera_rate)
        self._is_idle = threading.Event()  # no image of this camera is being rendered
        self._is_idle.set()
        name = f"{handle.camera.name}_camera"
        self._colors = node.publisher(f"{name}/color/image_raw", Image)
        self._depths = node.publisher(f"{name}/depth/image_raw", Image)
        self._infos = [
            node.publisher(f"{name}/{kind}/camera_info", CameraInfo)
            for kind in ("color", "depth")
        ]

    def publish(self, snapshot: Snapshot) -> None:
        """Publish subscribed topics that are due; never wait for an image.

        An image is skipped while the previous one is still being rendered.
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
        """Unregister its topics, once the image in progress is published."""
        self._renderer.close()
        for publisher in (self._colors, self._depths, *self._infos):
            publisher.unregister()

    def _render(self, snapshot: Snapshot) -> None:
        try:
            image = self._handle.image(snapshot)
        except Tool0Error as error:
            self._node.log_error(f"camera '{self._handle.camera.name}': {error}")
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
            header=self._node.header(time, self._frame),
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
            header=self._node.header(time, self._frame),
            height=camera.height,
            width=camera.width,
            distortion_model="plumb_bob",  # and no distortion
            D=[0.0] * 5,
            K=K.ravel().tolist(),
            R=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            P=[*K[0], 0.0, *K[1], 0.0, *K[2], 0.0],
        )


NAME = "robot_state_publisher"
_CHECK_RATE = 1.0
"""Checks whether the child process is alive [Hz] of simulated time."""
_GRACE = 5.0
"""Time for the child process to end by itself [wall s]."""


@final
class RobotStatePublisher:
    """The frames of links and cameras.

    The real robot_state_publisher runs as a child process.  If it is not installed, or
    has ended, tool0's own kinematics publish the same frames.
    """

    def __init__(self, node: RosNode, robot: Robot) -> None:
        self._node, self._robot = node, robot
        self._joints = robot.description.model.joints
        self._rate = PublishRate(node.options.tf_pub_rate)
        self._check_rate = PublishRate(_CHECK_RATE)
        self._static = node.publisher("/tf_static", TFMessage, latch=True)
        self._publisher: Any = None
        self._program = find_node(f"{NAME}/{NAME}")
        self._child: ChildProcess | None = None
        if self._program is None:
            self._take_over()
        else:
            self._static.publish(camera_transforms(node, robot))
            self._child = self._start()

    def publish(self, snapshot: Snapshot) -> None:
        """Publish the frames of movable joints if they are due; watch the child."""
        child = self._child
        if child is None:
            if self._rate.is_due(snapshot.time):
                names, values = snapshot.joint_names, snapshot.position
                position = dict(zip(names, values, strict=True))
                movable = (joint for joint in self._joints if joint.is_movable)
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
        """Restart the child: roscpp nodes do not notice a new master."""
        if self._child is not None:
            old, self._child = self._child, self._start()
            old.close()

    def close(self) -> None:
        """End the child, and unregister the topics."""
        if self._child is not None:
            self._child.close()
        if self._publisher is not None:
            self._publisher.unregister()
        self._static.unregister()

    def _start(self) -> ChildProcess:
        node, options = self._node, self._node.options
        name = node.name(NAME)
        node.master.call("setParam", f"{name}/publish_frequency", options.tf_pub_rate)
        node.master.call("setParam", f"{name}/tf_prefix", node.tf_prefix)
        environment = {**os.environ, "ROS_NAMESPACE": options.root or "/"}
        command = [str(self._program), f"__name:={NAME}"]
        return ChildProcess(command, environment=environment, grace=_GRACE)

    def _take_over(self) -> None:
        """Publish the fixed frames, and from now on the movable ones."""
        node, robot = self._node, self._robot
        fixed = (joint for joint in self._joints if not joint.is_movable)
        transforms = self._transforms(fixed, {}, robot.time)
        self._static.publish(transforms + camera_transforms(node, robot))
        self._publisher = node.publisher("/tf", TFMessage, queue_size=100)

    def _transforms(
        self, joints: Iterable[Joint], position: Mapping[str, float], time: float
    ) -> list[Message]:
        frame = self._node.frame
        return [
            transform_message(
                self._node.header(time, frame(joint.parent)),
                frame(joint.child),
                joint_transform(joint, position),
            )
            for joint in joints
        ]
