"""The cameras in ROS: pictures, what formed them, and their frames.

Colours and depth are of one picture, so they have one frame: the colours' optical one.
"""

from __future__ import annotations

import threading
from typing import Any, final

from tool0.api.robot import Robot
from tool0.api.sensors import CameraHandle
from tool0.control.publish_rate import PublishRate
from tool0.description.camera import Camera
from tool0.errors import Tool0Error
from tool0.interfaces.ros1.conversions import Message
from tool0.interfaces.ros1.node import RosNode, Worker
from tool0.sensing.cameras import CameraImage
from tool0.sensing.snapshot import Snapshot


def frame_of(camera: Camera, node: RosNode, robot: Robot) -> str:
    """Return the name of the optical frame, which begins as those of the links."""
    name = f"{robot.description.prefix}{camera.name}_camera_color_optical_frame"
    return _prefixed(name, node)


def camera_transforms(node: RosNode, robot: Robot) -> list[Message]:
    """Return where each camera is on its link, as geometry_msgs/TransformStamped."""
    from geometry_msgs.msg import TransformStamped

    found = []
    for view in robot.cameras.values():
        camera = view.camera
        message: Any = TransformStamped(header=node.header(robot.time))
        link = camera.link or robot.description.model.root
        message.header.frame_id = _prefixed(link, node)
        message.child_frame_id = frame_of(camera, node, robot)
        place, turn = message.transform.translation, message.transform.rotation
        place.x, place.y, place.z = camera.T_link_camera.position
        turn.w, turn.x, turn.y, turn.z = camera.T_link_camera.quat_wxyz
        found.append(message)
    return found


@final
class CameraEdges:
    """The topics of all cameras.  What nobody subscribes to is not drawn."""

    def __init__(self, node: RosNode, robot: Robot) -> None:
        self._worker = Worker("tool0 ros1 cameras")
        self._edges = [
            CameraEdge(node, view, frame_of(view.camera, node, robot), self._worker)
            for view in robot.cameras.values()
        ]

    def publish(self, snapshot: Snapshot) -> None:
        """Have drawn what is due; never waits for it."""
        for edge in self._edges:
            edge.publish(snapshot)

    def restart(self) -> None:
        """Forget nothing: the rates see that time went back."""

    def close(self) -> None:
        """Present them no longer."""
        self._worker.close()
        for edge in self._edges:
            edge.close()


@final
class CameraEdge:
    """``image_raw`` and ``camera_info`` of colours and depth, of one camera."""

    def __init__(
        self, node: RosNode, view: CameraHandle, frame: str, worker: Worker
    ) -> None:
        from sensor_msgs.msg import CameraInfo, Image

        self._node, self._view, self._worker = node, view, worker
        self._frame = frame
        self._image, self._info = Image, CameraInfo
        self._rate = PublishRate(node.options.camera_rate)
        self._is_free = threading.Event()  # no picture is being drawn
        self._is_free.set()
        name = f"{view.camera.name}_camera"
        self._colors = node.publisher(f"{name}/color/image_raw", Image)
        self._depths = node.publisher(f"{name}/depth/image_raw", Image)
        self._infos = [
            node.publisher(f"{name}/{kind}/camera_info", CameraInfo)
            for kind in ("color", "depth")
        ]

    def publish(self, snapshot: Snapshot) -> None:
        """Publish what is subscribed to, if it is time to.

        A picture that comes too late for the rate is left out.
        """
        if not self._rate.is_due(snapshot.time):
            return
        wanted = [self._colors, self._depths]
        if not any(publisher.get_num_connections() for publisher in wanted):
            self._publish_infos(snapshot.time)
        elif self._is_free.is_set():
            self._is_free.clear()
            self._worker.defer(lambda: self._draw(snapshot))

    def close(self) -> None:
        """Present it no longer."""
        for publisher in (self._colors, self._depths, *self._infos):
            publisher.unregister()

    def _draw(self, snapshot: Snapshot) -> None:
        try:
            image = self._view.image(snapshot)
        except Tool0Error as error:
            self._node.complain(f"camera '{self._view.camera.name}': {error}")
            return
        finally:
            self._is_free.set()
        self._publish_image(image)
        self._publish_infos(image.time)

    def _publish_image(self, image: CameraImage) -> None:
        if self._colors.get_num_connections():
            self._colors.publish(self._picture(image.time, "rgb8", image.rgb))
        if self._depths.get_num_connections():
            depth = image.depth.astype("<f4", copy=False)
            self._depths.publish(self._picture(image.time, "32FC1", depth))

    def _publish_infos(self, time: float) -> None:
        for publisher in self._infos:
            if publisher.get_num_connections():
                publisher.publish(self._described(time))

    def _picture(self, time: float, encoding: str, pixels: Any) -> Message:
        height, width = pixels.shape[:2]
        return self._image(
            header=self._header(time),
            height=height,
            width=width,
            encoding=encoding,
            is_bigendian=0,
            step=pixels.nbytes // height,
            data=pixels.tobytes(),
        )

    def _described(self, time: float) -> Message:
        camera = self._view.camera
        K = camera.intrinsics
        P = [*K[0], 0.0, *K[1], 0.0, *K[2], 0.0]
        return self._info(
            header=self._header(time),
            height=camera.height,
            width=camera.width,
            distortion_model="plumb_bob",  # and no distortion
            D=[0.0] * 5,
            K=K.ravel().tolist(),
            R=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            P=P,
        )

    def _header(self, time: float) -> Message:
        header = self._node.header(time)
        header.frame_id = self._frame
        return header


def _prefixed(frame: str, node: RosNode) -> str:
    prefix = node.frame_prefix
    return f"{prefix}/{frame}" if prefix else frame
