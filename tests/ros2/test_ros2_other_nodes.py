"""Other nodes publish what tool0 publishes: it makes way for them."""

from __future__ import annotations

import pytest
from ros import Bringup
from ros2_client import Client, Message
from ros2_domain import Domain, interrupt
from waits import until

JOINT_STATE = "sensor_msgs/msg/JointState"
TF = "tf2_msgs/msg/TFMessage"

STATE_PUBLISHER = """
import rclpy
from tf2_msgs.msg import TFMessage
rclpy.init()
node = rclpy.create_node("robot_state_publisher")
publisher = node.create_publisher(TFMessage, "/tf_static", 1)
rclpy.spin(node)
"""
NAMESAKE = """
import rclpy
rclpy.init()
rclpy.spin(rclpy.create_node("robot_state_publisher"))
"""

CLOCK = """
import rclpy, time
from rosgraph_msgs.msg import Clock
rclpy.init()
node = rclpy.create_node("another_clock")
publisher = node.create_publisher(Clock, "/clock", 10)
start = time.monotonic()
while True:
    message = Clock()
    message.clock.sec, part = divmod(int(1e9 * (time.monotonic() - start)), 10**9)
    message.clock.sec += 5000
    message.clock.nanosec = part
    publisher.publish(message)
    time.sleep(0.02)
"""


def names(client: Client, topic: str) -> list[str]:
    """Return the nodes that publish a topic."""
    return [one.node for one in client.publishers(topic)]


def test_frames_are_left_to_a_robot_state_publisher(
    domain: Domain, client: Client, bringup: Bringup
) -> None:
    def ours() -> int:
        return names(client, "/tf_static").count("/tool0")

    until(lambda: ours() == 2, "our frames: the links', the cameras'")
    other = domain.spawn("-c", STATE_PUBLISHER)
    until(lambda: ours() == 1, "the cameras' frames alone")
    interrupt(other)
    other.wait(30.0)
    until(lambda: ours() == 2, "our frames again")
    with client.listening("/tf_static", TF, latched=True) as frames:
        frames.wait_for(
            lambda message: (
                "base_link" in [m.child_frame_id for m in message.transforms]
            )
        )


def test_a_robot_state_publisher_that_publishes_nothing_is_no_reason_to_stop(
    domain: Domain, client: Client, bringup: Bringup
) -> None:
    """The graph may list one forever after its process has ended."""
    other = domain.spawn("-c", NAMESAKE)
    until(lambda: "/robot_state_publisher" in client.nodes(), "the other node")
    with client.listening("/tf", TF) as frames:

        def time(message: Message) -> float:
            return float(message.transforms[0].header.stamp)

        start = time(frames.last)  # then three looks at the other nodes
        frames.wait_for_new(lambda message: time(message) > start + 3.0)
    assert names(client, "/tf_static").count("/tool0") == 2
    interrupt(other)
    other.wait(30.0)


def test_one_clock_is_enough_and_the_stamps_follow_it(
    domain: Domain, client: Client, bringup: Bringup
) -> None:
    assert len(names(client, "/clock")) == 1
    other = domain.spawn("-c", CLOCK)
    until(lambda: names(client, "/clock") == ["/another_clock"], "only that clock")
    with client.listening("/joint_states", JOINT_STATE) as states:
        late = states.wait_for(lambda state: state.header.stamp > 5000.0)
        assert late.header.stamp < 5000.0 + 60.0
        interrupt(other)
        other.wait(30.0)
        until(lambda: len(names(client, "/clock")) == 1, "our clock again")
        stamps = [state.header.stamp for state in states.next(100)]
    assert stamps[-1] - stamps[0] == pytest.approx(99 * 0.008)
