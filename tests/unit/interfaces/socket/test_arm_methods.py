"""The arm of a running bringup, asked over a real socket."""

from collections.abc import Iterator

import pytest
from fake_robot import SUCCEEDED, FakeRobot
from tool0.interfaces.socket.client import RemoteRobot

from tool0.description.transform import Pose
from tool0.errors import ControlError

POSE = Pose(xyz=(0.4, -0.1, 0.3), rpy=(3.14, 0.0, 0.5))


@pytest.fixture
def robot(served_robot: FakeRobot) -> FakeRobot:
    return served_robot


@pytest.fixture
def remote(robot: FakeRobot) -> Iterator[RemoteRobot]:
    with RemoteRobot() as visitor:
        yield visitor


def test_a_pose_is_reached_as_asked(robot: FakeRobot, remote: RemoteRobot) -> None:
    assert remote.arm.move_to(POSE, speed=0.3, tip="pad").wait() == SUCCEEDED
    remote.arm.move_linear(POSE, speed=0.1, angular_speed=0.5, relative_to="tool0")
    assert robot.calls == [
        ("to", {"pose": POSE, "speed": 0.3, "tip": "pad"}),
        (
            "linear",
            {"pose": POSE, "speed": 0.1, "angular_speed": 0.5, "relative_to": "tool0"},
        ),
    ]


def test_what_is_left_out_is_left_to_the_facade(
    robot: FakeRobot, remote: RemoteRobot
) -> None:
    remote.arm.move_to(POSE, arm="arm")
    remote.arm.move_linear(POSE)
    assert robot.calls == [("to", {"pose": POSE}), ("linear", {"pose": POSE})]


def test_an_unknown_arm_is_an_error_and_moves_nothing(
    robot: FakeRobot, remote: RemoteRobot
) -> None:
    with pytest.raises(ControlError, match=r"no arm 'left'; valid: arm"):
        remote.arm.move_to(POSE, arm="left")
    assert robot.calls == []


def test_poses_come_as_they_are(robot: FakeRobot, remote: RemoteRobot) -> None:
    assert remote.arm.pose() == robot.arm.pose()
    asked = {"tip": "pad", "relative_to": "base"}
    assert remote.arm.pose(**asked) == robot.arm.pose(**asked)
    assert remote.arm.poses() == {"tool0": robot.arm.pose()}
