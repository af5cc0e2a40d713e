"""What a bring-up publishes: parameters, clock, joint states, the wrench; its node."""

from __future__ import annotations

import subprocess
import sys
import threading
from types import ModuleType

import numpy as np
import pytest
from ros import Bringup, Ros
from ros_client import call, listening
from ur5_rig import ARM, ARM_JOINTS, GRIPPER, HOME

from tool0.installation.ros1.master import Master
from tool0.ros1.bridge import with_mesh_files

ENGINES = ("mujoco", "gazebo")
JOINTS = tuple(sorted((*ARM_JOINTS, "finger_joint")))
"""ros_control's order."""
in_mujoco = pytest.mark.parametrize("bringup", ["mujoco"], indirect=True)
"""For what does not depend on the physics."""


@in_mujoco
def test_robot_description_is_what_describe_prints(ros: Ros, bringup: Bringup) -> None:
    described = subprocess.run(
        [sys.executable, "-m", "tool0", "describe", "urdf"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    expected = with_mesh_files(described).strip()
    assert ros.parameter("/robot_description").strip() == expected


@in_mujoco
def test_the_controllers_yaml_is_at_their_names(ros: Ros, bringup: Bringup) -> None:
    arm = ros.parameter(f"/{ARM}")
    assert arm["type"] == "effort_controllers/JointTrajectoryController"
    assert arm["joints"][0] == "shoulder_pan_joint"
    assert ros.parameter(f"/{ARM}/gains/shoulder_pan_joint/p") == 4000
    assert ros.parameter(f"/{ARM}/constraints/goal_time") == 0.6
    assert ros.parameter(f"/{GRIPPER}/joints") == ["finger_joint"]
    assert ros.parameter("/joint_state_controller/publish_rate") == 125
    assert ros.parameter("/use_sim_time") is True


def test_the_clock_advances_by_8_ms(rospy: ModuleType, bringup: Bringup) -> None:
    from rosgraph_msgs.msg import Clock

    with listening("/clock", Clock) as clock:
        times = [message.clock.to_nsec() for message in clock.next(250)]
    steps = np.diff(times)
    assert steps.min() > 0
    assert np.median(steps) == 8_000_000


def test_rostopic_measures_125_joint_states_a_second(
    ros: Ros, bringup: Bringup
) -> None:
    ros.wait_for_rate("/joint_states", 125.0)


def test_joint_states_are_in_ros_control_s_order_and_sane(
    rospy: ModuleType, bringup: Bringup
) -> None:
    from sensor_msgs.msg import JointState

    with listening("/joint_states", JointState) as states:
        first, last = states.next(50)[::49]
    assert tuple(last.name) == JOINTS
    place = dict(zip(last.name, last.position, strict=True))
    arm = [place[joint] for joint in ARM_JOINTS]
    np.testing.assert_allclose(arm, HOME, atol=0.02)
    assert place["finger_joint"] == pytest.approx(0.0, abs=0.01)
    assert np.abs(last.velocity).max() < 0.01
    effort = dict(zip(last.name, last.effort, strict=True))
    assert 10.0 < abs(effort["shoulder_lift_joint"]) < 60.0  # [N·m]: it carries the arm
    assert last.header.stamp > first.header.stamp


@in_mujoco
def test_the_wrench_comes_at_its_rate_and_can_be_tared(
    rospy: ModuleType, bringup: Bringup
) -> None:
    from geometry_msgs.msg import WrenchStamped
    from std_srvs.srv import Trigger

    with listening("/wrench", WrenchStamped) as wrench:
        messages = wrench.next(60)
        stamps = [message.header.stamp.to_nsec() for message in messages]
        assert set(np.diff(stamps)) == {8_000_000}
        assert {message.header.frame_id for message in messages} == {"tool0"}
        assert messages[-1].wrench.force.z == pytest.approx(9.03, rel=0.02)
        assert call("/ur_hardware_interface/zero_ftsensor", Trigger).success
        later = wrench.next(80)[-1].wrench
        assert later.force.z == pytest.approx(0.0, abs=0.05)
        assert later.torque.x == pytest.approx(0.0, abs=0.01)


@in_mujoco
def test_the_tools_of_ros_list_it(ros: Ros, bringup: Bringup) -> None:
    for tool, name in (
        ("rosnode", "/gazebo"),
        ("rosparam", "/robot_description"),
        ("rosservice", "/controller_manager/list_controllers"),
        ("rostopic", "/joint_states"),
    ):
        assert name in ros.run(tool, "list").splitlines()


def test_ctrl_c_unregisters_its_names(ros: Ros) -> None:
    bringup = ros.bring_up("--ns=leaves")
    assert ros.address_of("/leaves/gazebo") is not None
    ros.wait_for_service("/leaves/robot_state_publisher/set_logger_level")
    assert bringup.end() == 0
    assert ros.address_of("/leaves/gazebo") is None
    assert [name for name in ros.services() if name.startswith("/leaves")] == []


@pytest.mark.usefixtures("rospy")
def test_a_node_can_be_unregistered_with_all_its_names(ros: Ros) -> None:
    """With a parameter, too, which rospy subscribes to with its first warning."""
    uri, topic = "http://127.0.0.1:1/", "/gone/topic"
    master, other = Master("/gone/node"), Master("/other/node")
    for each in (master, other):
        each.call("registerPublisher", topic, "std_msgs/Bool", uri)
        each.call("registerSubscriber", "/gone/heard", "std_msgs/Bool", uri)
    master.call("registerService", "/gone/service", "rosrpc://127.0.0.1:1", uri)
    master.call("subscribeParam", uri, "/rosout_disable_topics_generation")
    assert ros.address_of("/gone/node") == uri
    master.unregister_all(uri)
    assert ros.address_of("/gone/node") is None
    assert "/gone/service" not in ros.services()
    assert ros.publishers()[topic] == ["/other/node"]
    other.unregister_all(uri)
    assert topic not in ros.publishers()


@pytest.mark.usefixtures("rospy")
def test_two_clocks_can_change_roles_while_time_advances() -> None:
    from tool0.ros1.node import RosClock

    clock = RosClock(publish=True)
    is_over, errors = threading.Event(), []

    def advance() -> None:
        now = 0.0
        while not is_over.is_set():
            now += 0.001
            try:
                clock.advance(now)
            except Exception as error:
                errors.append(error)

    thread = threading.Thread(target=advance)
    thread.start()
    for _ in range(20):
        clock.follow_other()
        assert not clock.is_publisher
        clock.start_publishing()
        assert clock.is_publisher
    is_over.set()
    thread.join()
    clock.follow_other()
    assert errors == []
