"""A cell under one controller manager: every robot by its prefix."""

from __future__ import annotations

from types import ModuleType

import pytest
from ros import Bringup, Ros
from ros_client import (
    arm_client,
    call,
    connected,
    follow_goal,
    listening,
    outcome,
    trajectory,
)
from ros_frames import assert_agrees, looked_up
from ur5_rig import ARM, ARM_JOINTS, GRIPPER, HOME

from tool0.description.config import DescriptionConfig
from tool0.description.loading import load_description

ROBOTS = ("left=ur5e+2f85@0,0.5,0", "right=ur10e+hande@0,-0.5,0,0,0,90deg")
OPTIONS = ("--robots", *ROBOTS, "--gripper-action")
SIDES = ("left", "right")
JOINTS = sorted(
    [f"{side}_{joint}" for side in SIDES for joint in ARM_JOINTS]
    + ["left_finger_joint", "right_hande_left_finger_joint"]
)
SUCCEEDED = 3
SHIFT = {"left": 0.3, "right": -0.2}


def position() -> dict[str, float]:
    """Return the position of each joint now."""
    from sensor_msgs.msg import JointState

    with listening("/joint_states", JointState) as states:
        message = states.messages[-1]
    return dict(zip(message.name, message.position, strict=True))


def test_one_manager_has_the_controllers_of_all(
    rospy: ModuleType, bringup: Bringup
) -> None:
    from controller_manager_msgs.srv import ListControllers

    listed = call("/controller_manager/list_controllers", ListControllers).controller
    running = {one.name for one in listed if one.state == "running"}
    assert running == {
        "joint_state_controller",
        *(f"{side}_{name}" for side in SIDES for name in (ARM, GRIPPER)),
    }


def test_both_arms_follow_at_once(rospy: ModuleType, bringup: Bringup) -> None:
    from sensor_msgs.msg import JointState

    clients = {side: arm_client(f"{side}_{ARM}") for side in SIDES}
    with listening("/joint_states", JointState) as states:
        for side, client in clients.items():
            target = [q + SHIFT[side] for q in HOME]
            joints = [f"{side}_{joint}" for joint in ARM_JOINTS]
            client.send_goal(follow_goal(trajectory([(1.5, target)], joints)))
        results = [outcome(client) for client in clients.values()]
        assert [status for status, _ in results] == [SUCCEEDED] * 2
        assert list(states.messages[-1].name) == JOINTS
        elbows = [JOINTS.index(f"{side}_elbow_joint") for side in SIDES]
        assert any(
            all(abs(message.velocity[elbow]) > 0.1 for elbow in elbows)
            for message in states.messages
        )
    measured = position()
    for side in SIDES:
        assert measured[f"{side}_elbow_joint"] == pytest.approx(
            HOME[2] + SHIFT[side], abs=0.01
        )


def test_frames_connect_the_tools(rospy: ModuleType, bringup: Bringup) -> None:
    model = load_description(DescriptionConfig(robots=ROBOTS)).model
    found = looked_up("left_tool0", "right_tool0")
    assert_agrees(found, model, position(), "left_tool0", "right_tool0")


def test_a_gripper_that_slides_is_commanded_in_metres(
    rospy: ModuleType, bringup: Bringup
) -> None:
    from actionlib import SimpleActionClient
    from control_msgs.msg import (
        GripperCommand,
        GripperCommandAction,
        GripperCommandGoal,
    )

    for side, joint, target in (
        ("right", "right_hande_left_finger_joint", 0.01),  # [m]
        ("left", "left_finger_joint", 0.3),  # [rad]
    ):
        client = connected(
            SimpleActionClient(f"{side}_{GRIPPER}/gripper_cmd", GripperCommandAction)
        )
        client.send_goal(GripperCommandGoal(GripperCommand(target, 0.0)))
        status, result = outcome(client)
        assert (status, result.reached_goal) == (SUCCEEDED, True)
        assert result.position == pytest.approx(target, rel=0.02)
        assert position()[joint] == pytest.approx(target, rel=0.02)


def test_each_arm_has_a_wrench_of_its_own(rospy: ModuleType, bringup: Bringup) -> None:
    from geometry_msgs.msg import WrenchStamped
    from std_srvs.srv import Trigger

    with (
        listening("/left_wrench", WrenchStamped) as left,
        listening("/right_wrench", WrenchStamped) as right,
    ):
        before = right.next(60)[-1]
        assert before.header.frame_id == "right_tool0"
        assert abs(before.wrench.force.z) > 5.0  # the weight of the gripper [N]
        assert call("/left_ur_hardware_interface/zero_ftsensor", Trigger).success
        tared, other = left.next(80)[-1], right.next()[-1]
    assert tared.header.frame_id == "left_tool0"
    assert tared.wrench.force.z == pytest.approx(0.0, abs=0.05)
    assert other.wrench.force.z == pytest.approx(before.wrench.force.z, abs=0.1)


def test_cameras_have_the_names_of_their_robots(
    ros: Ros, rospy: ModuleType, bringup: Bringup
) -> None:
    from sensor_msgs.msg import CameraInfo

    for camera, parent in (("right_wrist", "right_tool0"), ("scene", "world")):
        with listening(f"/{camera}_camera/color/camera_info", CameraInfo) as infos:
            frame = infos.next()[0].header.frame_id
        assert frame == f"{camera}_camera_color_optical_frame"
        looked_up(parent, frame)


def test_gazebo_s_services_know_all_links(rospy: ModuleType, bringup: Bringup) -> None:
    from gazebo_msgs.srv import GetLinkState, GetModelProperties

    state = call("/gazebo/get_link_state", GetLinkState, "robot::right_tool0", "world")
    assert state.success
    names = call("/gazebo/get_model_properties", GetModelProperties, "robot")
    assert {"left_elbow_joint", "right_elbow_joint"} <= set(names.joint_names)
