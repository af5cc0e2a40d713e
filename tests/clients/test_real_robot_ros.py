"""Clients of ROS 1 and ROS 2 on a real robot: as on a simulated one."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import closing, contextmanager

import pytest
from promised import require_ros
from ros import Bringup, Ros
from ros2_domain import Domain
from ros2_rig import REACHED, follow, trajectory
from ur5_rig import ARM_JOINTS, HOME
from ur_address import free_host
from waits import until

import tool0

pytestmark = pytest.mark.flaky(reruns=3)  # three programs in real time on two cores

PAN = ARM_JOINTS[0]
AWAY = (0.3, *HOME[1:])
SCALED = "scaled_joint_trajectory_controller"

ROSPY = """
import sys, rospy, actionlib
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectoryPoint
rospy.init_node("client")
name, place, joints = sys.argv[1], float(sys.argv[2]), sys.argv[3:]
state = rospy.wait_for_message("/joint_states", JointState, 30.0)
at = dict(zip(state.name, state.position))
client = actionlib.SimpleActionClient(
    "/%s/follow_joint_trajectory" % name, FollowJointTrajectoryAction)
assert client.wait_for_server(rospy.Duration(30.0))
goal = FollowJointTrajectoryGoal()
goal.trajectory.joint_names = joints
positions = [place] + [at[joint] for joint in joints[1:]]
goal.trajectory.points = [JointTrajectoryPoint(
    positions=positions, velocities=[0.0] * 6, time_from_start=rospy.Duration(2.0))]
client.send_goal(goal)
assert client.wait_for_result(rospy.Duration(30.0))
print(client.get_state(), client.get_result().error_string)
"""


@contextmanager
def controller() -> Iterator[tuple[tool0.Robot, tuple[str, ...]]]:
    """Run a robot's controller; yield the robot, and the options for tool0 on it."""
    host = free_host()
    options = ("--ur", "--ur-active-gripper", "--dt", "0.002", "--arm", "ur5")
    with closing(Bringup(os.environ, *options, "--ur-host", host)) as simulated:
        simulated.wait()
        with connected(simulated) as twin:
            yield twin, ("--arm", "ur5", "--hardware", host)


@contextmanager
def connected(bringup: Bringup) -> Iterator[tool0.Robot]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_RUNTIME_DIR", bringup.runtime_folder)
        robot = tool0.connect()
    with robot:
        yield robot


def enable(robot: tool0.Robot) -> None:
    box = robot.arm.control_box
    link = box.state.link
    assert link is not None
    box.enable_motion(link.serial_number)
    box.set_speed_slider(1.0)
    until(lambda: box.state.speed_scaling == 1.0, "the speed slider")


def test_a_client_of_ros_2_moves_it_once_its_motion_is_enabled() -> None:
    with Domain() as domain, controller() as (twin, options):
        bringup = domain.bring_up(*options)
        with closing(domain.client()) as client, connected(bringup) as robot:
            goal = trajectory([(2.0, AWAY)])
            assert not follow(client, goal, SCALED).is_accepted
            enable(robot)
            status, result = follow(client, goal, SCALED).outcome()
            assert (status, result.error_string) == ("succeeded", REACHED)
        until(
            lambda: abs(twin.joint_state.position[PAN] - AWAY[0]) < 2e-3,
            lambda: f"{AWAY[0]}, not {twin.joint_state.position[PAN]}",
        )


def test_a_client_of_ros_1_moves_it_once_its_motion_is_enabled() -> None:
    require_ros()
    with Ros() as ros, controller() as (twin, options):
        with closing(ros.bring_up(*options)) as bringup, connected(bringup) as robot:
            enable(robot)
            (name,) = (
                status.name
                for status in robot.controllers()
                if status.is_running and PAN in status.joints and "traj" in status.name
            )
            words = (ROSPY, name, "0.3", *ARM_JOINTS)
            assert ros.python(*words).split()[0] == "3"  # SUCCEEDED
        until(
            lambda: abs(twin.joint_state.position[PAN] - 0.3) < 2e-3,
            lambda: f"0.3, not {twin.joint_state.position[PAN]}",
        )
