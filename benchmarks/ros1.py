"""Latency from a command on a ROS topic to a joint's effort, compared with rospy.

There are three processes: the robot in ROS, a client that commands the robot, and a
plain rospy node that receives the same messages on another topic.  Times are read from
the monotonic clock, which all processes of a machine share.
"""

from __future__ import annotations

import json
import os
import socket
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass

import tool0

COMMANDS = 200
JOINT = "shoulder_pan_joint"
STEP = 0.1
"""Amplitude of the commands [rad]."""
JUMP = 0.5
"""Smallest change of effort within a tick that only a command causes [N·m]."""
PAUSE = 0.1
"""Time between two commands [s]."""


@dataclass(frozen=True)
class Latency:
    """Latencies from the call of ``publish`` in the client [s]."""

    p50: float
    p99: float
    plain_p50: float
    """Latency until a node that has no other work receives the message [s]."""


def latency() -> Latency:
    """Measure the latencies in separate processes.

    rospy allows only one node in each process.
    """
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    environment = {
        **os.environ,
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_IP": "127.0.0.1",
        "TOOL0_KERNEL": "python",  # the engine's efforts are observed in each step
    }
    answer = subprocess.run(
        [sys.executable, __file__, "robot"],
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    sent, effort, heard = json.loads(answer.stdout)
    ours = _delays(sent, effort)
    return Latency(
        p50=statistics.median(ours),
        p99=statistics.quantiles(ours, n=100)[98],
        plain_p50=statistics.median(_delays(sent, heard)),
    )


def _delays(sent: Sequence[float], seen: Sequence[float]) -> list[float]:
    """Return the delay from each command to the next event [s].

    Delays longer than PAUSE are omitted.
    """
    found = []
    for start in sent:
        after = min((when for when in seen if when > start), default=None)
        if after is not None and after - start < PAUSE:
            found.append(after - start)
    if len(found) < 0.9 * len(sent):
        raise RuntimeError(f"only {len(found)} of {len(sent)} commands had an effect")
    return found


def _robot() -> None:
    """Run the robot, and print the times of commands, effort changes and receptions."""
    from tool0.ros1.bridge import Ros1Bridge
    from tool0.ros1.options import Ros1Options

    with tool0.bringup() as robot:
        index = robot.snapshot.joint_names.index(JOINT)
        jumps: list[float] = []
        write, last = robot.engine.write, [0.0]

        def watched(effort: Sequence[float]) -> None:
            if abs(effort[index] - last[0]) > JUMP:
                jumps.append(time.perf_counter())
            last[0] = effort[index]
            write(effort)

        robot.engine.write = watched  # type: ignore[method-assign]
        with Ros1Bridge(robot, Ros1Options(roscore=True)):
            listener = _start("listener")
            client = _start("client")
            sent = json.loads(client.communicate()[0])
            heard = json.loads(listener.communicate("over")[0])
    print(json.dumps([sent, jumps, heard]))


def _start(role: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, __file__, role],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def _listener() -> None:
    """Record the times of reception until standard input ends."""
    import rospy
    from trajectory_msgs.msg import JointTrajectory

    heard: list[float] = []
    rospy.init_node("listener")
    rospy.Subscriber(
        "/plain", JointTrajectory, lambda _: heard.append(time.perf_counter())
    )
    sys.stdin.read()
    print(json.dumps(heard))


def _client() -> None:
    """Move the joint back and forth through the controller's topic.

    Each message is also published on the plain topic.
    """
    import rospy
    from sensor_msgs.msg import JointState
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

    rospy.init_node("client")
    controller = "/eff_joint_traj_controller"
    topics = [
        rospy.Publisher(name, JointTrajectory, queue_size=1)
        for name in (f"{controller}/command", "/plain")
    ]
    joints = rospy.get_param(f"{controller}/joints")
    state = rospy.wait_for_message("/joint_states", JointState)
    position = dict(zip(state.name, state.position, strict=True))
    pause = threading.Event()
    while not all(topic.get_num_connections() for topic in topics):
        pause.wait(0.01)
    sent = []
    for k in range(COMMANDS):
        goal = {**position, JOINT: position[JOINT] + (STEP if k % 2 == 0 else 0.0)}
        point = JointTrajectoryPoint(
            positions=[goal[joint] for joint in joints],
            time_from_start=rospy.Duration(0.5),
        )
        message = JointTrajectory(joint_names=joints, points=[point])
        sent.append(time.perf_counter())
        for topic in topics:
            topic.publish(message)
        pause.wait(PAUSE)
    print(json.dumps(sent))


if __name__ == "__main__":
    from tool0.installation.ros1.messages import import_messages

    import_messages()
    {"robot": _robot, "listener": _listener, "client": _client}[sys.argv[1]]()
