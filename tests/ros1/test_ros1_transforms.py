"""/tf and /tf_static, by the real robot_state_publisher and by us."""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType

import numpy as np
import pytest
from ros import Bringup, Ros
from ros_client import listening, publishing, trajectory
from ur5_rig import ARM, AWAY
from waits import until

from tool0.description.forward_kinematics import link_poses
from tool0.description.loading import assemble

LAST = "left_inner_finger"
"""A link at the end of a chain that mimic joints move."""
ELSEWHERE = (0.2, -1.4, 1.7, -1.4, -1.7, -0.3)
PREFIX = "left/"


@pytest.fixture(scope="module")
def bringup(ros: Ros) -> Iterator[Bringup]:
    bringup = ros.bring_up("--tf-prefix", PREFIX.rstrip("/"))
    yield bringup
    bringup.close()


def test_robot_state_publisher_agrees_with_our_kinematics(
    ros: Ros, rospy: ModuleType, bringup: Bringup
) -> None:
    until(
        lambda: ros.publishers().get("/tf") == ["/robot_state_publisher"],
        "robot_state_publisher",
    )
    assert worst_transform(AWAY, PREFIX) < 1e-6


def test_transforms_go_on_where_robot_state_publisher_ends(
    ros: Ros, rospy: ModuleType, bringup: Bringup
) -> None:
    ros.run("rosnode", "kill", "/robot_state_publisher")
    bringup.wait_for("tool0 publishes /tf")
    until(lambda: ros.publishers().get("/tf") == ["/gazebo"], "our own transforms")
    assert worst_transform(ELSEWHERE, PREFIX) < 1e-6
    assert latched_frames(PREFIX) > {"wrist_camera_color_optical_frame", "tool0"}


def latched_frames(prefix: str) -> set[str]:
    """Return the frames that our own /tf_static tells, to who comes late too."""
    from tf2_msgs.msg import TFMessage

    with listening("/tf_static", TFMessage) as static:
        ours = static.wait_for(lambda m: m._connection_header["callerid"] == "/gazebo")
    return {one.child_frame_id.removeprefix(prefix) for one in ours.transforms}


def worst_transform(target: tuple[float, ...], prefix: str = "") -> float:
    """Return by how much tf2 and our kinematics differ while the arm moves [m | 1]."""
    import tf2_ros
    from sensor_msgs.msg import JointState
    from tf2_msgs.msg import TFMessage
    from trajectory_msgs.msg import JointTrajectory

    model = assemble("ur5", gripper="2f85").model
    buffer = tf2_ros.Buffer()
    listener = tf2_ros.TransformListener(buffer)
    with (
        listening("/joint_states", JointState) as states,
        listening("/tf", TFMessage) as tf,
        publishing(f"/{ARM}/command", JointTrajectory) as command,
    ):
        command(trajectory([(1.0, target)]))
        received = [
            message
            for message in states.next(125)
            if max(map(abs, message.velocity)) > 0.1
        ]
        tf.next(2)
        frames = {
            one.child_frame_id: one.header.frame_id
            for message in tf.messages
            for one in message.transforms
        }
        stamps = {message.transforms[0].header.stamp for message in tf.messages}
    listener.unregister()
    assert frames[f"{prefix}forearm_link"] == f"{prefix}upper_arm_link"
    compared = [message for message in received if message.header.stamp in stamps]
    assert len(compared) > 20
    worst = 0.0
    for message in compared:
        values = dict(zip(message.name, message.position, strict=True))
        T_root = link_poses(model, values)
        for link in ("tool0", LAST):
            ours = T_root["base_link"].inverse() @ T_root[link]
            theirs = buffer.lookup_transform(
                f"{prefix}base_link", f"{prefix}{link}", message.header.stamp
            ).transform
            place, turn = theirs.translation, theirs.rotation
            quat_wxyz = np.array([turn.w, turn.x, turn.y, turn.z])
            worst = max(
                worst,
                float(
                    np.abs(
                        np.subtract(ours.position, (place.x, place.y, place.z))
                    ).max()
                ),
                1.0 - abs(float(quat_wxyz @ ours.quat_wxyz)),
            )
    return worst
