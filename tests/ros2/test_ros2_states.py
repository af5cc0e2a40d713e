"""What a robot publishes: joint states, frames, time, description; rates and QoS."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from xml.etree import ElementTree

import numpy as np
import pytest
from ros import Bringup
from ros2_client import Client, Topic
from ros2_rig import JTC, STATE
from ur5_rig import ARM_JOINTS
from waits import until

OPTIONS = ("--arm", "ur5e")
JOINT_STATE = "sensor_msgs/msg/JointState"
TF = "tf2_msgs/msg/TFMessage"


@pytest.fixture(scope="module")
def joint_states(client: Client, bringup: Bringup) -> Iterator[Topic]:
    with client.listening("/joint_states", JOINT_STATE) as states:
        yield states


def test_joint_states_have_all_joints_at_500_hz_of_simulated_time(
    joint_states: Topic,
) -> None:
    received = joint_states.next(1000)
    stamps = np.array([one.header.stamp for one in received])
    gaps = np.diff(stamps)
    assert (gaps > 0).all()
    assert np.median(gaps) == pytest.approx(0.002, abs=1e-9)
    assert np.mean(gaps) == pytest.approx(0.002, rel=0.05)  # a busy machine skips
    first = received[0]
    assert set(first.name) >= {*ARM_JOINTS, "finger_joint"}
    assert first.header.frame_id == "base_link"
    for values in (first.position, first.velocity, first.effort):
        assert len(values) == len(first.name)
        assert np.isfinite(values).all()


def test_topics_have_ros_s_types_and_quality_of_service(
    client: Client, joint_states: Topic
) -> None:
    for topic, kind, is_latched in (
        ("/joint_states", JOINT_STATE, False),
        ("/clock", "rosgraph_msgs/msg/Clock", False),
        ("/tf", TF, False),
        ("/tf_static", TF, True),
        ("/robot_description", "std_msgs/msg/String", True),
        (f"/{JTC}/controller_state", STATE, False),
        (
            "/controller_manager/activity",
            "controller_manager_msgs/msg/ControllerManagerActivity",
            True,
        ),
    ):
        found = partial(client.publishers, topic)
        for one in until(found, f"a publisher of {topic}"):
            assert one.type == kind, topic
            assert one.reliable, topic
            assert one.latched == is_latched, topic


def test_the_description_comes_late_subscribers_too_and_has_the_limits(
    client: Client, bringup: Bringup
) -> None:
    with client.listening(
        "/robot_description", "std_msgs/msg/String", latched=True
    ) as topic:
        robot = ElementTree.fromstring(topic.last.data)
    limits = {
        joint.get("name"): joint.find("limit") for joint in robot.findall("joint")
    }
    for name in ARM_JOINTS:
        limit = limits[name]
        assert limit is not None
        assert float(limit.get("lower", "0")) < float(limit.get("upper", "0"))
    tags = robot.findall("ros2_control")
    driven = {joint.get("name") for tag in tags for joint in tag.iter("joint")}
    assert driven >= set(ARM_JOINTS)


def test_frames_are_connected_from_the_world_to_the_tool(
    client: Client, bringup: Bringup
) -> None:
    parent: dict[str, str] = {}
    with client.listening("/tf_static", TF, latched=True) as static:
        parent |= {one.child_frame_id: one.header.frame_id for one in all_of(static)}
    with client.listening("/tf", TF) as moving:
        moving.next(5)
        parent |= {one.child_frame_id: one.header.frame_id for one in all_of(moving)}
    frame, passed = "tool0", []
    while frame != "world":
        passed.append(frame)
        frame = parent[frame]
    assert "shoulder_link" in passed
    assert "base_link" in passed


def all_of(topic: Topic) -> list[object]:
    return [one for message in topic.since(0) for one in message.transforms]


def test_the_clock_is_that_of_the_stamps_also_for_best_effort(
    client: Client, joint_states: Topic
) -> None:
    kind = "rosgraph_msgs/msg/Clock"
    with client.listening("/clock", kind, reliable=False) as clock:
        before = joint_states.last.header.stamp
        assert clock.next()[0].clock == pytest.approx(before, abs=0.5)
        times = np.array([one.clock for one in clock.next(50)])
        assert (np.diff(times) > 0).all()
