"""A node of this process, and ROS's tools, meet a robot of ``tool0 bringup --ros1``."""

from types import ModuleType

import pytest
from ros import PATIENCE, Bringup, Ros


def test_messages_arrive(rospy: ModuleType, bringup: Bringup) -> None:
    from sensor_msgs.msg import JointState

    first = rospy.wait_for_message("joint_states", JointState, PATIENCE)
    later = rospy.wait_for_message("joint_states", JointState, PATIENCE)
    assert later.header.stamp > first.header.stamp
    assert "elbow_joint" in first.name


@pytest.mark.parametrize(
    ("tool", "name"),
    [
        ("rosnode", "/gazebo"),
        ("rosparam", "/robot_description"),
        ("rosservice", "/controller_manager/list_controllers"),
        ("rostopic", "/joint_states"),
    ],
)
def test_the_tools_list_it(tool: str, name: str, ros: Ros, bringup: Bringup) -> None:
    assert name in ros.run(tool, "list").splitlines()


def test_it_ends_by_ctrl_c_and_takes_its_names_along(ros: Ros) -> None:
    bringup = ros.bring_up("--ns=leaves")
    assert ros.address_of("/leaves/gazebo") is not None
    ros.wait_for_service("/leaves/robot_state_publisher/set_logger_level")
    assert bringup.end() == 0
    assert ros.address_of("/leaves/gazebo") is None
    assert [name for name in ros.services() if name.startswith("/leaves")] == []
