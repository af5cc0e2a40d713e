"""The rclpy side of the ROS 2 benchmark, which runs under ROS 2's Python.

Times are read from the monotonic clock, which all processes of a machine share.  Each
role prints one JSON value.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any

import rclpy
from builtin_interfaces.msg import Duration
from controller_manager_msgs.srv import ListControllers
from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

CONTROLLER = "/joint_trajectory_controller"
JOINT = "shoulder_pan_joint"
ARM = ("shoulder_", "elbow_", "wrist_")
"""Prefixes of the names of the arm's joints."""
STEP = 0.1
"""Amplitude of the commands [rad]."""
DURATION = Duration(nanosec=500_000_000)
PAUSE = 0.1
"""Time between two commands [wall s]."""
SKIPPED = 250
"""Number of first messages of a subscription that are not counted."""


def states(node: Node, count: str) -> list[list[float]]:
    """Return the stamps [s] and reception times [s] of messages on /joint_states."""
    received: list[list[float]] = []

    def receive(message: Any) -> None:
        now = time.monotonic()
        stamp = message.header.stamp
        received.append([stamp.sec + 1e-9 * stamp.nanosec, now])

    node.create_subscription(JointState, "/joint_states", receive, 10)
    while len(received) < SKIPPED + int(count):
        rclpy.spin_once(node)
    return received[SKIPPED:]


def commands(node: Node, count: str) -> list[float]:
    """Move a joint back and forth, and return the times of the commands [s]."""
    states: list[Any] = []
    subscription = node.create_subscription(
        JointState, "/joint_states", states.append, 1
    )
    publisher = node.create_publisher(
        JointTrajectory, f"{CONTROLLER}/joint_trajectory", 1
    )
    while not states or not publisher.get_subscription_count():
        rclpy.spin_once(node, timeout_sec=0.1)
    node.destroy_subscription(subscription)
    position = dict(zip(states[-1].name, states[-1].position, strict=True))
    joints = [name for name in position if name.startswith(ARM)]
    sent = []
    for k in range(int(count)):
        goal = {**position, JOINT: position[JOINT] + (STEP if k % 2 == 0 else 0.0)}
        message = JointTrajectory(joint_names=joints)
        point = JointTrajectoryPoint(positions=[goal[name] for name in joints])
        point.time_from_start = DURATION
        message.points = [point]
        sent.append(time.monotonic())
        publisher.publish(message)
        time.sleep(PAUSE)
    return sent


def active(node: Node, *controllers: str) -> float:
    """Return the time at which all controllers are active [s].

    Print "ready" when the client is ready.
    """
    client = node.create_client(ListControllers, "/controller_manager/list_controllers")
    print("ready", flush=True)
    while True:
        if not client.wait_for_service(timeout_sec=60.0):
            raise SystemExit("no controller manager")
        future = client.call_async(ListControllers.Request())
        rclpy.spin_until_future_complete(node, future, timeout_sec=10.0)
        found = {one.name: one.state for one in future.result().controller}
        if all(found.get(name) == "active" for name in controllers):
            return time.monotonic()


def flood_topic(node: Node) -> None:
    """Publish trajectories as fast as possible, without end."""
    publisher = node.create_publisher(
        JointTrajectory, f"{CONTROLLER}/joint_trajectory", 10
    )
    while not publisher.get_subscription_count():
        rclpy.spin_once(node, timeout_sec=0.1)
    message = JointTrajectory(joint_names=[JOINT])
    point = JointTrajectoryPoint(positions=[0.0], time_from_start=DURATION)
    message.points = [point]
    print("floods", flush=True)
    while True:
        publisher.publish(message)


def flood_service(node: Node) -> None:
    """Call a service as fast as possible, without end."""
    client = node.create_client(ListControllers, "/controller_manager/list_controllers")
    client.wait_for_service()
    waiting = [client.call_async(ListControllers.Request()) for _ in range(20)]
    print("floods", flush=True)
    while True:
        rclpy.spin_once(node)
        waiting = [future for future in waiting if not future.done()]
        while len(waiting) < 20:
            waiting.append(client.call_async(ListControllers.Request()))


if __name__ == "__main__":
    rclpy.init()
    role, *arguments = sys.argv[1:]
    roles = {
        "states": states,
        "commands": commands,
        "active": active,
        "flood_topic": flood_topic,
        "flood_service": flood_service,
    }
    print(json.dumps(roles[role](Node("benchmark"), *arguments)), flush=True)
    rclpy.shutdown()
