"""Failures around a robot in ROS: master, clients, subscribers, other nodes."""

from __future__ import annotations

import signal
import socket
from collections.abc import Callable
from types import ModuleType
from urllib.parse import urlsplit
from xmlrpc.client import ServerProxy

import pytest
from processes import Watch, descendants, listening, program
from ros import TIMEOUT, Bringup, Ros, system_python
from waits import until

CLIENT = """
import sys, rospy, actionlib
from control_msgs.msg import *
from trajectory_msgs.msg import *
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64
rospy.init_node("client", anonymous=True)
CONTROLLER = "/eff_joint_traj_controller"
JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]

def positions():
    message = rospy.wait_for_message("/joint_states", JointState, 20)
    return dict(zip(message.name, message.position))

def point(wrist, after, **other):
    now = positions()
    now["wrist_3_joint"] = wrist
    return JointTrajectoryPoint(positions=[now[j] for j in JOINTS],
        time_from_start=rospy.Duration(after), **other)

def action():
    client = actionlib.SimpleActionClient(CONTROLLER + "/follow_joint_trajectory",
        FollowJointTrajectoryAction)
    assert client.wait_for_server(rospy.Duration(20)) or client.wait_for_server()
    return client

def goal(wrist, after):
    goal = FollowJointTrajectoryGoal()
    goal.trajectory = JointTrajectory(joint_names=JOINTS, points=[point(wrist, after)])
    return goal
"""
"""The beginning of a user's script."""

MOVES = """
client = action()
client.send_goal_and_wait(goal(float(sys.argv[1]), 0.5), rospy.Duration(20))
print(client.get_state(), round(positions()["wrist_3_joint"], 2))
"""
SUCCEEDED, FAILED = 3, 2
Wrist = Callable[[], float]


def moves(ros: Ros, wrist: float) -> bool:
    """Return whether a new client can move the robot."""
    answer = ros.python(CLIENT + MOVES, str(wrist))
    return answer.split() == [str(SUCCEEDED), str(wrist)]


@pytest.fixture
def wrist(rospy: ModuleType, bringup: Bringup) -> Callable[[], float]:
    """Return a function that reads the last joint [rad]."""
    from sensor_msgs.msg import JointState

    def read() -> float:
        message = rospy.wait_for_message("/joint_states", JointState, TIMEOUT)
        return float(message.position[message.name.index("wrist_3_joint")])

    return read


def test_a_master_that_goes_and_comes_back(own_ros: Ros) -> None:
    bringup = own_ros.bring_up()
    ours = {name for name in own_ros.services() if "/rosout" not in name}
    follower = own_ros.spawn("rostopic", "hz", "/joint_states")
    until(lambda: n_subscribers(own_ros) >= 2, "it beside robot_state_publisher")
    own_ros.stop()
    bringup.wait_for("is gone")
    assert follower.exit_status is None
    own_ros.start()
    bringup.wait_for("registered again")
    assert own_ros.parameter("/robot_description")
    assert own_ros.parameter("/eff_joint_traj_controller/type")
    until(lambda: own_ros.services() >= ours, "our services")
    assert moves(own_ros, 0.3)
    own_ros.run("rostopic", "echo", "-n1", "/tf")


def test_a_client_that_dies_amid_its_goal(
    ros: Ros, bringup: Bringup, wrist: Wrist
) -> None:
    client = ros.spawn(
        *(system_python(), "-c"),
        CLIENT + "client = action()\nclient.send_goal(goal(0.4, 2.0))\nrospy.spin()",
    )
    until(lambda: wrist() > 0.02, "the wrist moving")
    client.close()
    until(lambda: abs(wrist() - 0.4) < 0.02, "the goal reached nevertheless")
    assert moves(ros, 0.1)


def test_a_subscriber_that_stalls_delays_nobody(ros: Ros, bringup: Bringup) -> None:
    script = CLIENT + (
        "import os, signal\n"
        "rospy.Subscriber('/joint_states', JointState, lambda m: None)\n"
        "positions()\nos.kill(os.getpid(), signal.SIGSTOP)\n"
    )
    ros.spawn(system_python(), "-c", script)
    until(lambda: n_subscribers(ros) >= 2, "a subscriber beside the publisher of /tf")
    ros.wait_for_rate("/joint_states", 125.0, window=500)
    assert moves(ros, 0.2)


def n_subscribers(ros: Ros) -> int:
    _, subscribers, _ = ros.call_master("getSystemState")
    return len(dict(subscribers).get("/joint_states", ()))


def test_garbage_on_our_ports(ros: Ros, bringup: Bringup) -> None:
    address = ros.address_of("/gazebo")
    assert address is not None
    with ServerProxy(address) as node:
        _, _, (protocol, host, port) = node.requestTopic(
            "/test", "/joint_states", [["TCPROS"]]
        )
    assert protocol == "TCPROS"
    targets = [(host, port), (urlsplit(address).hostname, urlsplit(address).port)]
    for target in targets:
        for garbage in (
            b"",
            b"\xff" * 4096,
            b"\x04\x00\x00\x00abcd",
            b"GET / HTTP/1.1",
        ):
            with socket.create_connection(target) as peer:
                peer.sendall(garbage)
    assert moves(ros, 0.25)


def test_another_type_on_our_topic(ros: Ros, bringup: Bringup, wrist: Wrist) -> None:
    before = wrist()
    ros.python(
        CLIENT + "p = rospy.Publisher(CONTROLLER + '/command', Float64, queue_size=1)\n"
        "rospy.sleep(0.3)\np.publish(1.0)\nrospy.sleep(0.3)"
    )
    assert wrist() == pytest.approx(before, abs=1e-3)
    assert moves(ros, 0.15)


def test_a_hundred_thousand_points(ros: Ros, bringup: Bringup, wrist: Wrist) -> None:
    script = CLIENT + (
        "first = point(0.35, 0.5).positions\n"
        "points = [JointTrajectoryPoint(positions=first,\n"
        "    time_from_start=rospy.Duration(1.0 + 0.001 * i)) for i in range(100000)]\n"
        "huge = goal(0.0, 1.0)\nhuge.trajectory.points = points\n"
        "client = action()\nclient.send_goal(huge)\n"
        "while client.get_state() == 0: rospy.sleep(0.05)\n"
        "print(client.get_state())\n"
    )
    assert int(ros.python(script, timeout=90.0)) == 1  # ACTIVE
    until(lambda: abs(wrist() - 0.35) < 0.02, "its first point reached")
    assert moves(ros, 0.1)  # and so it is preempted


def test_what_we_start_ends_with_us_when_we_are_killed(masterless: Ros) -> None:
    bringup = masterless.bring_up("--roscore")
    started = descendants(bringup.process.pid)
    assert len(started) >= 5  # supervisors, roscore and its two, and others
    watch = Watch(started)
    bringup.process.kill()
    assert watch.all_ended(TIMEOUT)
    until(lambda: not masterless.is_up, "the master's end")


def test_a_roscore_of_ours_listens_on_this_machine_alone_and_ends_with_us(
    masterless: Ros,
) -> None:
    bringup = masterless.bring_up("--roscore")
    pids = [bringup.process.pid, *descendants(bringup.process.pid)]
    addresses = {pid: listening(pid).get("tcp", set()) for pid in pids}
    # Only now: a process may have become one of roscpp's nodes, which have no choice.
    in_python = [pid for pid in pids if program(pid).startswith("python")]
    assert len(in_python) >= 5
    assert set().union(*(addresses[pid] for pid in in_python)) == {"0100007F"}
    assert masterless.is_up
    assert bringup.end(signal.SIGTERM) == 0
    assert not masterless.is_up


def test_without_a_master_it_says_so(masterless: Ros) -> None:
    bringup = masterless.bring_up(wait=False)
    assert bringup.wait_for_end() == FAILED
    assert masterless.uri in bringup.text
    assert "--roscore" in bringup.text


def test_a_second_robot_needs_a_namespace(ros: Ros, bringup: Bringup) -> None:
    other = ros.bring_up("--name", "second", wait=False)
    assert other.wait_for_end() == FAILED
    assert "/gazebo" in other.text
    assert "--ns" in other.text
    assert moves(ros, 0.2)


def test_two_robots_under_one_master(own_ros: Ros) -> None:
    first = own_ros.bring_up()
    second = own_ros.bring_up("--ns", "left/arm", "--name", "second")
    publishers = own_ros.publishers()
    assert publishers["/clock"] == ["/gazebo"]
    assert publishers["/left/arm/joint_states"] == ["/left/arm/gazebo"]
    assert "/left/arm/controller_manager/list_controllers" in own_ros.services()
    assert own_ros.parameter("/left/arm/robot_description")
    script = CLIENT + (
        "rospy.sleep(0.3)\n"  # which waits for /clock first
        "other = rospy.wait_for_message('/left/arm/joint_states', JointState, 20)\n"
        "print(abs((other.header.stamp - rospy.Time.now()).to_sec()) < 0.2)"
    )
    assert own_ros.python(script).strip() == "True"
    assert first.end() == 0
    second.wait_for("publishing /clock")
    own_ros.run("rostopic", "echo", "-n1", "/clock")
    own_ros.run("rosservice", "call", "/left/arm/controller_manager/list_controllers")


def test_of_two_clocks_one_gives_way(own_ros: Ros) -> None:
    bringup = own_ros.bring_up()
    other = own_ros.spawn(
        *(system_python(), "-c"),
        "import rospy, time\n"
        "from rosgraph_msgs.msg import Clock\n"
        "rospy.init_node('another', disable_rostime=True)\n"
        "clock = rospy.Publisher('/clock', Clock, queue_size=1)\n"
        "while not rospy.is_shutdown():\n"
        "    clock.publish(Clock(clock=rospy.Time.from_sec(time.time() % 1e4)))\n"
        "    time.sleep(0.01)",
    )
    bringup.wait_for("/another publishes /clock")
    assert own_ros.publishers()["/clock"] == ["/another"]
    other.close()
    bringup.wait_for("publishing /clock")
    assert moves(own_ros, 0.2)


def test_rosnode_kill_ends_the_bringup(own_ros: Ros) -> None:
    bringup = own_ros.bring_up()
    own_ros.run("rosnode", "kill", "/gazebo")
    assert bringup.wait_for_end() == 0
