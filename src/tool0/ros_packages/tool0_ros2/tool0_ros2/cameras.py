"""The topics and frames of the cameras."""

import base64
import math
import threading
import zlib
from array import array
from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import TransformStamped
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import CameraInfo, Image
from tf2_msgs.msg import TFMessage

from tool0_ros2 import requests
from tool0_ros2.bridge import Context, Rate, Update
from tool0_ros2.connection import (
    Connection,
    RequestFailedError,
)
from tool0_ros2.copied import Pose, to_transform
from tool0_ros2.errors import TransportError
from tool0_ros2.kinematics import LinkTree
from tool0_ros2.messages import fill_frame, to_vector
from tool0_ros2.requests import Camera, Picture

_WAIT = 0.5
"""Longest wait of the thread before it checks whether it must end [wall s]."""
_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class CamerasPart:
    """The cameras of a namespace.

    A thread with a separate connection requests one image after another.  Rendering and
    sending therefore do not delay other parts.  Images that are due while the thread is
    busy are skipped.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        names = context.names
        root = LinkTree(context.description["urdf"]).root
        listed = context.ask(requests.list_cameras(), "cameras") or []
        full = [item["name"] for item in listed if names.owns(item["link"] or "")]
        self._cameras = [
            _Camera(
                context,
                item,
                own
                if (own := names.to_ros(item["name"])) not in full
                else item["name"],
                item["link"] or root,
            )
            for item in listed
            if item["name"] in full
        ]
        self._rate = Rate(context.options.camera_rate)
        self._wanted = threading.Event()
        self._is_closing = False
        self._thread: threading.Thread | None = None
        self._static: Any = None
        if self._cameras:
            self._static = context.node.create_publisher(
                TFMessage, "/tf_static", _LATCHED
            )
            frames = [camera.transform() for camera in self._cameras]
            self._static.publish(TFMessage(transforms=frames))
            self._thread = threading.Thread(
                target=self._run, name="cameras", daemon=True
            )
            self._thread.start()

    def wants(self) -> Sequence[str]:
        return ()

    def publish(self, update: Update) -> None:
        """Make the thread request the pictures that have subscribers."""
        if not self._rate.is_due(update.time):
            return
        for camera in self._cameras:
            if camera.is_wanted():
                self._wanted.set()
            else:
                camera.publish_info(update.stamp)

    def close(self) -> None:
        self._is_closing = True
        if self._thread is not None:
            self._wanted.set()
            self._thread.join()
            self._context.node.destroy_publisher(self._static)
        for camera in self._cameras:
            camera.close()

    def _run(self) -> None:
        connection: Connection | None = None
        while not self._is_closing:
            if not self._wanted.wait(_WAIT) or self._is_closing:
                continue
            self._wanted.clear()
            for camera in self._cameras:
                if not camera.is_wanted():
                    continue
                try:
                    if connection is None:
                        connection = Connection(self._context.connection.name)
                        connection.start()
                    camera.publish_picture(
                        connection.call(requests.take_picture(camera=camera.full_name))
                    )
                except (TransportError, RequestFailedError) as error:
                    self._context.report.error(f"{camera.full_name}: {error}")
        if connection is not None:
            connection.close()


class _Camera:
    """Topics ``NAME_camera/color`` and ``NAME_camera/depth`` of one camera.

    Color and depth are parts of one image.  Color and depth therefore share the optical
    frame of the color image.
    """

    def __init__(self, context: Context, camera: Camera, name: str, link: str) -> None:
        """Create the topics for an item of ``list_cameras``."""
        self._context, self._camera, self._link = context, camera, link
        self.full_name = camera["name"]
        names, node = context.names, context.node
        self._frame = names.frame(names.to_model(f"{name}_camera_color_optical_frame"))
        qos = QoSProfile(depth=2)
        topic = names.topic(f"{name}_camera")
        self._colors = node.create_publisher(Image, f"{topic}/color/image_raw", qos)
        self._depths = node.create_publisher(Image, f"{topic}/depth/image_raw", qos)
        self._infos = [
            node.create_publisher(CameraInfo, f"{topic}/{kind}/camera_info", qos)
            for kind in ("color", "depth")
        ]

    def is_wanted(self) -> bool:
        """Return whether any image has subscribers."""
        images = (self._colors, self._depths)
        return any(publisher.get_subscription_count() for publisher in images)

    def transform(self) -> Any:
        """Return the transform from the camera's link to its optical frame."""
        message = TransformStamped()
        message.header.frame_id = self._context.names.frame(self._link)
        message.child_frame_id = self._frame
        pose, transform = self._camera["pose"], message.transform
        frame = to_transform(
            Pose(xyz=to_vector(pose["xyz"]), rpy=to_vector(pose["rpy"]))
        )
        fill_frame(transform.translation, transform.rotation, frame)
        return message

    def publish_picture(self, picture: Picture) -> None:
        """Publish the response to ``take_picture``."""
        stamp = self._context.clock.to_ros(picture["time"])
        if self._colors.get_subscription_count():
            colors = self._image(picture, stamp, "rgb8", picture["rgb"], 3)
            self._colors.publish(colors)
        if self._depths.get_subscription_count():
            self._depths.publish(
                self._image(picture, stamp, "32FC1", picture["depth"], 4)
            )
        self.publish_info(stamp, picture["K"])

    def publish_info(self, stamp: Any, K: Any = None) -> None:
        """Publish the projection.  ``K`` is the intrinsic matrix, shape (3, 3)."""
        readers = [item for item in self._infos if item.get_subscription_count()]
        if not readers:
            return
        rows = K or self._intrinsics()
        message = CameraInfo()
        message.header.stamp = stamp
        message.header.frame_id = self._frame
        message.width, message.height = self._camera["width"], self._camera["height"]
        message.distortion_model = "plumb_bob"  # the coefficients mean no distortion
        message.d = [0.0] * 5
        message.k = [float(value) for row in rows for value in row]
        message.r = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
        message.p = [float(value) for row in rows for value in (*row, 0.0)]
        for publisher in readers:
            publisher.publish(message)

    def close(self) -> None:
        for publisher in (self._colors, self._depths, *self._infos):
            self._context.node.destroy_publisher(publisher)

    def _intrinsics(self) -> list[list[float]]:
        width, height = self._camera["width"], self._camera["height"]
        half = math.tan(0.5 * self._camera["field_of_view"])
        focal = 0.5 * height / half
        x, y = 0.5 * (width - 1), 0.5 * (height - 1)  # the center of the image
        return [[focal, 0.0, x], [0.0, focal, y], [0.0, 0.0, 1.0]]

    def _image(
        self,
        picture: Picture,
        stamp: Any,
        encoding: str,
        pixels: str,
        pixel_size: int,
    ) -> Any:
        message = Image()
        message.header.stamp = stamp
        message.header.frame_id = self._frame
        message.width, message.height = picture["width"], picture["height"]
        message.encoding = encoding
        message.step = pixel_size * picture["width"]
        message.data = array("B", zlib.decompress(base64.b64decode(pixels)))
        return message
