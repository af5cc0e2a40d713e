"""Failures around a robot in ROS 2: its node, its subscribers, its own end."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import numpy as np
import pytest
from processes import Watch, descendants
from ros import TIMEOUT, Bringup
from ros2_client import Client
from ros2_domain import Domain
from ros2_rig import JTC, STATE, follow, go, trajectory, wait_until_moving
from ur5_rig import ARM_JOINTS, AWAY, HOME
from waits import until

import tool0
from tool0.protocol.control_box_state import RobotMode

FREEDRIVE = "freedrive_mode_controller"
JOINT_STATE = "sensor_msgs/msg/JointState"
NEVER_READS = """
import os, signal, rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState
rclpy.init()
node = Node("never_reads")
received = []
node.create_subscription(JointState, "/joint_states", received.append, 10)
while not received:
    rclpy.spin_once(node)
os.kill(os.getpid(), signal.SIGSTOP)
"""

SENDS_MANY_GOALS = """
import sys, time, rclpy
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
rclpy.init()
node = Node("sends_many_goals")
every = QoSProfile(history=HistoryPolicy.KEEP_ALL)
client = ActionClient(
    node, FollowJointTrajectory, sys.argv[1],
    goal_service_qos_profile=every, result_service_qos_profile=every,
)
client.wait_for_server()
point = JointTrajectoryPoint(positions=[0.0, -1.5, 0.0, -1.5, 0.0, 0.0])
point.time_from_start.nanosec = 300_000_000
goal = FollowJointTrajectory.Goal(
    trajectory=JointTrajectory(joint_names=sys.argv[2:], points=[point])
)
ended = []
def follow(response):
    response.result().get_result_async().add_done_callback(ended.append)
for _ in range(100):  # without looking at what arrives
    client.send_goal_async(goal).add_done_callback(follow)
    time.sleep(0.005)
until = time.monotonic() + 30.0
while len(ended) < 100 and time.monotonic() < until:
    rclpy.spin_once(node, timeout_sec=0.1)
print(len(ended), "goals have ended", flush=True)
"""


def node_process(bringup: Bringup) -> int:
    """Return the process of the bring-up's node."""
    (found,) = (
        pid
        for pid in descendants(bringup.process.pid)
        if b"tool0_ros2" in Path(f"/proc/{pid}/cmdline").read_bytes()
        and b"supervisor" not in Path(f"/proc/{pid}/cmdline").read_bytes()
    )
    return found


def test_a_subscriber_that_never_reads_delays_nobody(
    domain: Domain, client: Client, bringup: Bringup
) -> None:
    stalled = domain.spawn("-c", NEVER_READS)

    def is_stopped() -> bool:
        fields = Path(f"/proc/{stalled.pid}/stat").read_text().rpartition(")")[2]
        return fields.split()[0] == "T"

    until(is_stopped, "a subscriber that reads no more")
    with (
        client.listening("/joint_states", JOINT_STATE) as states,
        client.listening(f"/{JTC}/controller_state", STATE) as controller,
    ):
        stamps = [one.header.stamp for one in states.next(500)]
        assert 499 / (stamps[-1] - stamps[0]) == pytest.approx(125.0, rel=0.05)
        go(client, controller, HOME)
    os.kill(stalled.pid, signal.SIGKILL)


def test_every_goal_is_answered_however_fast_they_come(
    domain: Domain, bringup: Bringup
) -> None:
    action = f"/{JTC}/follow_joint_trajectory"
    child = domain.spawn("-c", SENDS_MANY_GOALS, action, *ARM_JOINTS)
    until(lambda: "100 goals have ended" in child.last_output(), "the ends", 60.0)


def test_a_node_that_dies_is_reported_and_restarted_amid_a_goal(
    client: Client, bringup: Bringup
) -> None:
    """The motion continues; clients find the robot again."""
    topic = f"/{JTC}/controller_state"
    with client.listening(topic, STATE) as states:
        go(client, states, HOME)
        follow(client, trajectory([(1.5, AWAY)]))
        wait_until_moving(states, 0.1)
        node = node_process(bringup)
        os.kill(node, signal.SIGKILL)
        bringup.wait_for("ROS 2")
        states.wait_for_new(
            lambda state: np.allclose(state.feedback.positions, AWAY, atol=0.02)
        )
        assert node_process(bringup) != node
        go(client, states, HOME)


def test_the_node_after_one_that_died_ends_freedrive(
    client: Client, bringup: Bringup, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", bringup.runtime_folder)
    with tool0.connect() as robot:
        box = robot.arm.control_box
        robot.switch(start=[FREEDRIVE], stop=[JTC])
        topic = f"/{FREEDRIVE}/enable_freedrive_mode"
        client.publish(topic, "std_msgs/msg/Bool", {"data": True})
        until(lambda: box.state.robot_mode is RobotMode.BACKDRIVE, "freedrive")
        os.kill(node_process(bringup), signal.SIGKILL)
        until(lambda: box.state.robot_mode is RobotMode.RUNNING, "its end")
        robot.switch(start=[JTC], stop=[FREEDRIVE])


def test_what_we_start_ends_with_us_when_we_are_killed(own_domain: Domain) -> None:
    bringup = own_domain.bring_up()
    started = descendants(bringup.process.pid)
    assert node_process(bringup) in started
    watch = Watch(started)
    bringup.process.kill()
    assert watch.all_ended(TIMEOUT)


def test_an_orderly_end_takes_the_node_along(own_domain: Domain) -> None:
    client = own_domain.client()
    bringup = own_domain.bring_up()
    until(lambda: "/controller_manager" in client.nodes(), "the manager's node")
    watch = Watch(descendants(bringup.process.pid))
    assert bringup.end(signal.SIGTERM) == 0
    assert watch.all_ended(TIMEOUT)
    until(lambda: client.nodes() == ["/client"], "an empty domain")
