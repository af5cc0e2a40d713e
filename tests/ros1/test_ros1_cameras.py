"""The cameras in ROS: what image_view, RViz and a perception stack subscribe to."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from types import ModuleType

import numpy as np
import pytest
from promised import require_gl
from ros import Bringup, Ros
from ros_client import Message, listening
from waits import until

from tool0.description.camera import default_cameras
from tool0.description.forward_kinematics import link_pose
from tool0.description.loading import assemble

WRIST, SCENE = default_cameras(assemble().model)
FRAME = "wrist_camera_color_optical_frame"


@pytest.fixture(scope="module")
def bringup(ros: Ros) -> Iterator[Bringup]:
    """Bring a robot up with something to see."""
    require_gl()
    bringup = ros.bring_up("--scene", "table_and_cubes", "--initial-pose", "ready")
    yield bringup
    bringup.close()


def test_a_picture_comes_with_its_depth_and_intrinsics(
    rospy: ModuleType, bringup: Bringup
) -> None:
    from sensor_msgs.msg import CameraInfo, Image

    with (
        listening("/wrist_camera/color/image_raw", Image) as colors,
        listening("/wrist_camera/depth/image_raw", Image) as depths,
        listening("/wrist_camera/color/camera_info", CameraInfo) as infos,
        listening("/wrist_camera/depth/camera_info", CameraInfo) as others,
    ):
        depths.next(3)

        def complete() -> int | None:
            stamps = [
                {message.header.stamp.to_nsec() for message in tuple(topic.messages)}
                for topic in (colors, depths, infos, others)
            ]
            return max(set.intersection(*stamps), default=None)

        stamp = until(complete, "a picture with all that belongs to it")
        color, depth, info, other = (
            next(m for m in topic.messages if m.header.stamp.to_nsec() == stamp)
            for topic in (colors, depths, infos, others)
        )
        ticks = sorted({m.header.stamp.to_nsec() for m in tuple(depths.messages)})
    assert min(np.diff(ticks)) >= 96_000_000  # 10 Hz, in steps of snapshots
    assert {m.header.frame_id for m in (color, depth, info, other)} == {FRAME}
    assert (color.width, color.height, color.encoding) == (640, 480, "rgb8")
    assert (depth.width, depth.height, depth.encoding) == (640, 480, "32FC1")
    assert (color.step, depth.step) == (1920, 2560)
    assert info.K == other.K == pytest.approx(WRIST.intrinsics.ravel())
    assert np.reshape(info.P, (3, 4))[:, :3] == pytest.approx(WRIST.intrinsics)
    assert (info.width, info.height, info.D) == (640, 480, (0.0,) * 5)
    picture = np.frombuffer(color.data, np.uint8).reshape(480, 640, 3)
    red, green, _ = np.moveaxis(picture.astype(int), -1, 0)
    is_cube = red > 3 * green  # the red one lies where the gripper comes down
    rows, columns = np.nonzero(is_cube)
    assert columns.mean() == pytest.approx(319.5, abs=8.0)
    away = np.frombuffer(depth.data, np.float32).reshape(480, 640)
    assert 0.05 < away[is_cube].min() < away[is_cube].max() < 0.3
    assert rows.mean() > 240.0


def test_the_optical_frames_hang_on_their_links(
    ros: Ros, rospy: ModuleType, bringup: Bringup
) -> None:
    import tf2_ros
    from rospy import Duration, Time

    buffer = tf2_ros.Buffer()
    listener = tf2_ros.TransformListener(buffer)
    try:
        for camera, link in ((WRIST, "tool0"), (SCENE, "world")):
            frame = f"{camera.name}_camera_color_optical_frame"
            found = buffer.lookup_transform(link, frame, Time(), Duration(30)).transform
            place, turn = found.translation, found.rotation
            expected = camera.T_link_camera
            assert (place.x, place.y, place.z) == pytest.approx(expected.position)
            got = turn.w, turn.x, turn.y, turn.z
            assert abs(np.dot(got, expected.quat_wxyz)) == pytest.approx(1.0)
        found = buffer.lookup_transform("world", FRAME, Time(), Duration(30)).transform
    finally:
        listener.unregister()
    pose = {"shoulder_lift_joint": -1.2, "elbow_joint": 1.9, "wrist_1_joint": -2.2708}
    model = assemble().model
    expected = (
        link_pose(model, {**pose, "wrist_2_joint": -1.5708}, "tool0")
        @ WRIST.T_link_camera
    )
    place = found.translation
    assert (place.x, place.y, place.z) == pytest.approx(expected.position, abs=0.01)


def test_what_formed_the_picture_comes_without_a_picture(
    rospy: ModuleType, bringup: Bringup
) -> None:
    from sensor_msgs.msg import CameraInfo

    with listening("/scene_camera/depth/camera_info", CameraInfo) as infos:
        (info,) = infos.next()
    assert info.header.frame_id == "scene_camera_color_optical_frame"
    assert list(info.K) == pytest.approx(SCENE.intrinsics.ravel().tolist())


def test_cameras_of_a_robot_with_a_prefix_have_frames_of_their_own(
    ros: Ros, rospy: ModuleType, bringup: Bringup
) -> None:
    from sensor_msgs.msg import CameraInfo
    from tf2_msgs.msg import TFMessage

    with (
        contextlib.closing(ros.bring_up("--ns", "left", "--prefix", "left_")),
        listening("/left/wrist_camera/color/camera_info", CameraInfo) as infos,
        listening("/tf_static", TFMessage) as static,
    ):
        frame = infos.wait_for(lambda m: True).header.frame_id
        assert frame == f"left_{FRAME}"
        static_transforms = static.wait_for(lambda m: frame in parents(m))
    assert parents(static_transforms)[frame] == "left_tool0"


def parents(message: Message) -> dict[str, str]:
    return {one.child_frame_id: one.header.frame_id for one in message.transforms}
