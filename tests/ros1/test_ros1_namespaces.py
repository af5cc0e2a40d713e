"""A cell with namespaces: each robot as if it were alone, in a namespace of its own."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
from ros import Bringup, Ros
from ros_client import (
    Message,
    arm_client,
    call,
    follow_goal,
    listening,
    outcome,
    publishing,
    trajectory,
)
from ros_frames import assert_agrees, looked_up
from ros_spawner import spawned
from ur5_rig import ARM, ARM_JOINTS, AWAY, GRIPPER, HOME
from waits import until

from tool0.description.camera import Camera
from tool0.description.cell_file import load_cell
from tool0.description.config import DescriptionConfig
from tool0.description.loading import load_description
from tool0.description.transform import Pose
from tool0.ros1.bridge import with_mesh_files

CELL = """
robots:
  - {name: left, arm: ur5, gripper: 2f85, base: {xyz: [0, 0.5, 0]}}
  - name: right
    arm: ur10e
    gripper: hande
    base: {xyz: [0, -0.5, 0], rpy: [0, 0, 90deg]}
namespaces: true
"""
SIDES = ("left", "right")
FINGERS = {"left": "finger_joint", "right": "hande_left_finger_joint"}
LOADED = ["joint_state_controller", ARM, GRIPPER, "joint_group_eff_controller"]
AT_THE_ROOT = ("/robot_description", "/joint_limits")
"""Parameters of a robot without a namespace."""
OWN = "own_controller"
OWN_YAML = f"""
{OWN}:
  type: effort_controllers/JointTrajectoryController
  joints: [wrist_3_joint]
  gains:
    wrist_3_joint: {{p: 10, i: 0, d: 0.1, i_clamp: 1}}
"""
ABORTED, REJECTED, SUCCEEDED = 4, 5, 3
INVALID_JOINTS = -2


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("cell") / "press.yaml"
    path.write_text(CELL)
    return path


@pytest.fixture(scope="module")
def bringup(ros: Ros, cell: Path) -> Iterator[Bringup]:
    for name in AT_THE_ROOT:  # of other bring-ups
        ros.call_master("deleteParam", name)
    bringup = ros.bring_up("--cell", str(cell))
    yield bringup
    bringup.close()


def states(side: str) -> dict[str, str]:
    """Return controller → state of the manager of one robot."""
    from controller_manager_msgs.srv import ListControllers

    response = call(f"/{side}/controller_manager/list_controllers", ListControllers)
    return {one.name: one.state for one in response.controller}


def switch(side: str, start: list[str], stop: list[str]) -> bool:
    from controller_manager_msgs.srv import SwitchController

    name = f"/{side}/controller_manager/switch_controller"
    ok: bool = call(name, SwitchController, start, stop, 2, False, 0.0).ok
    return ok


def joint_state(side: str) -> dict[str, float]:
    from sensor_msgs.msg import JointState

    with listening(f"/{side}/joint_states", JointState) as received:
        message = received.messages[-1]
    return dict(zip(message.name, message.position, strict=True))


def test_everything_of_a_robot_is_in_its_namespace(ros: Ros, bringup: Bringup) -> None:
    topics = {name for name, nodes in ros.publishers().items() if "/gazebo" in nodes}
    shared = {"clock", "gazebo", "rosout", "scene_camera", "tf_static"}
    firsts = {name.split("/")[1] for name in topics}
    assert firsts == {*SIDES, *shared}
    assert not [name for name in topics if name.startswith(("/left/left", "/left_"))]
    assert "/left/wrist_camera/color/image_raw" in topics
    assert [name for name in AT_THE_ROOT if ros.parameter(name) is not None] == []
    services = ros.services()
    assert "/left/controller_manager/list_controllers" in services
    assert "/controller_manager/list_controllers" not in services


def test_descriptions_and_parameters_are_those_of_a_robot_alone(
    ros: Ros, bringup: Bringup, cell: Path
) -> None:
    for robot in load_cell(cell).robots:
        alone = load_description(robot.description)
        described = ros.parameter(f"/{robot.name}/robot_description")
        assert described.strip() == with_mesh_files(alone.urdf).strip()
        arm = ros.parameter(f"/{robot.name}/{ARM}")
        assert arm["joints"] == list(ARM_JOINTS)
        assert set(arm["gains"]) == set(ARM_JOINTS)
        assert set(ARM_JOINTS) < set(arm["constraints"])
    assert ros.parameter(f"/left/{ARM}/gains/elbow_joint/p") == 2000
    limited = ros.parameter("/right/joint_limits")
    assert set(limited) == set(ARM_JOINTS)


def test_each_robot_has_a_manager_of_its_own(
    rospy: ModuleType, bringup: Bringup
) -> None:
    from controller_manager_msgs.srv import ListControllers, ReloadControllerLibraries

    for side, finger in (
        ("left", "finger_joint"),
        ("right", "hande_left_finger_joint"),
    ):
        name = f"/{side}/controller_manager/list_controllers"
        listed = {one.name: one for one in call(name, ListControllers).controller}
        assert list(listed) == LOADED
        claimed = listed[GRIPPER].claimed_resources[0].resources
        assert claimed == [finger]
        assert listed[ARM].claimed_resources[0].resources == sorted(ARM_JOINTS)
    assert switch("left", [], [GRIPPER, "joint_state_controller"])
    assert states("left")[GRIPPER] == "stopped"
    assert set(states("right").values()) == {"running", "initialized"}
    assert not switch("left", [f"left_{GRIPPER}"], [])
    assert GRIPPER in bringup.wait_for("SwitchController")
    assert switch("left", [GRIPPER, "joint_state_controller"], [])
    # All of one robot, as ``reload-libraries --restore`` does.
    before = states("right")
    reload = "/right/controller_manager/reload_controller_libraries"
    assert call(reload, ReloadControllerLibraries, True).ok
    assert states("right") == {}
    assert states("left")[ARM] == "running"
    load_all("right", before)
    assert states("right") == before


def load_all(side: str, controllers: dict[str, str]) -> None:
    """Load controllers, and start those that ran."""
    from controller_manager_msgs.srv import LoadController

    for name in controllers:
        assert call(
            f"/{side}/controller_manager/load_controller", LoadController, name
        ).ok
    running = [name for name, state in controllers.items() if state == "running"]
    assert switch(side, running, [])


def test_joint_states_have_the_names_of_a_robot_alone(
    rospy: ModuleType, bringup: Bringup
) -> None:
    for side, finger in FINGERS.items():
        assert list(joint_state(side)) == sorted((*ARM_JOINTS, finger))
    assert joint_state("right")["elbow_joint"] == pytest.approx(HOME[2], abs=0.02)


def test_both_follow_trajectories_without_prefixes(
    rospy: ModuleType, bringup: Bringup
) -> None:
    from control_msgs.msg import JointTolerance, JointTrajectoryControllerState
    from control_msgs.srv import QueryTrajectoryState

    clients = {side: arm_client(f"/{side}/{ARM}") for side in SIDES}
    targets = {"left": AWAY, "right": tuple(q - 0.2 for q in HOME)}
    feedback: list[Message] = []
    loose = [JointTolerance(name="elbow_joint", position=1.0)]
    for side, client in clients.items():
        goal = follow_goal(trajectory([(1.5, targets[side])]), path_tolerance=loose)
        client.send_goal(goal, feedback_cb=feedback.append)
    assert [outcome(client)[0] for client in clients.values()] == [SUCCEEDED] * 2
    assert {tuple(one.joint_names) for one in feedback} == {ARM_JOINTS}
    for side, target in targets.items():
        measured = joint_state(side)
        assert [measured[joint] for joint in ARM_JOINTS] == pytest.approx(
            target, abs=0.02
        )
        topic = f"/{side}/{ARM}/state"
        with listening(topic, JointTrajectoryControllerState) as received:
            message = received.messages[-1]
        assert tuple(message.joint_names) == ARM_JOINTS
        queried = call(
            f"/{side}/{ARM}/query_state", QueryTrajectoryState, message.header.stamp
        )
        assert tuple(queried.name) == ARM_JOINTS


def test_errors_name_the_joints_as_the_namespace_does(
    rospy: ModuleType, bringup: Bringup
) -> None:
    from control_msgs.msg import JointTolerance
    from trajectory_msgs.msg import JointTrajectory

    client = arm_client(f"/left/{ARM}")
    wrong = ["left_elbow_joint", *ARM_JOINTS[:2], *ARM_JOINTS[3:]]
    client.send_goal(follow_goal(trajectory([(1.0, HOME)], wrong)))
    status, result = outcome(client)
    assert (status, result.error_code) == (REJECTED, INVALID_JOINTS)
    assert "left_left" not in result.error_string
    assert "elbow_joint" in result.error_string
    assert "left_left" not in bringup.wait_for(f"/left/{ARM}/follow_joint_trajectory")
    with publishing(f"/right/{ARM}/command", JointTrajectory) as command:
        command(trajectory([(1.0, [99.0] * 6)]))
        line = bringup.wait_for(f"/right/{ARM}/command")
    assert "right_" not in line
    assert "shoulder_pan_joint" in line
    tight = [JointTolerance(name="elbow_joint", position=1e-4)]
    home = trajectory([(0.6, [q + 0.3 for q in HOME])])
    client.send_goal(follow_goal(home, path_tolerance=tight))
    status, result = outcome(client)
    assert status == ABORTED
    assert "elbow_joint" in result.error_string
    assert "left_" not in result.error_string


def test_a_controller_is_loaded_from_the_namespace(
    ros: Ros, rospy: ModuleType, bringup: Bringup, tmp_path: Path
) -> None:
    file = tmp_path / "own.yaml"
    file.write_text(OWN_YAML)
    ros.run("env", "ROS_NAMESPACE=right", "rosparam", "load", str(file))
    before = states("right")
    assert switch("right", [], [ARM])
    with spawned(ros, OWN, namespace="/right"):
        assert states("right")[OWN] == "running"
        assert OWN not in states("left")
        client = arm_client(f"/right/{OWN}")
        client.send_goal(follow_goal(trajectory([(0.5, [0.4])], ["wrist_3_joint"])))
        assert outcome(client)[0] == SUCCEEDED
        assert joint_state("right")["wrist_3_joint"] == pytest.approx(0.4, abs=0.05)
    assert switch("right", [ARM], [])
    assert states("right") == before


def test_tools_of_ros_work_in_a_namespace(ros: Ros, bringup: Bringup) -> None:
    printed = ros.run(
        *("env", "ROS_NAMESPACE=left", "rosservice", "call"),
        *("controller_manager/list_controllers", json.dumps({})),
    )
    assert f'name: "{ARM}"' in printed
    assert "left_" not in printed


def test_frames_have_prefixes_and_are_connected(
    ros: Ros, rospy: ModuleType, bringup: Bringup, cell: Path
) -> None:
    model = load_description(DescriptionConfig(cell=cell)).model
    until(
        lambda: (
            sorted(ros.publishers().get("/tf", []))
            == [f"/{side}/robot_state_publisher" for side in SIDES]
        ),
        "two robot_state_publishers",
    )
    position = {
        f"{side}_{joint}": q for side in SIDES for joint, q in joint_state(side).items()
    }

    def assert_connected() -> None:
        for target, source in (
            ("left/tool0", "right/tool0"),
            ("world", "left/left_inner_finger"),
        ):
            links = [name.replace("/", "_", 1) for name in (target, source)]
            assert_agrees(looked_up(target, source), model, position, *links)

    assert_connected()
    ros.run("rosnode", "kill", "/left/robot_state_publisher")
    bringup.wait_for("tool0 publishes /tf")
    until(lambda: "/gazebo" in ros.publishers()["/tf"], "our own transforms")
    assert_connected()
    looked_up("right/tool0", "left/wrist_camera_color_optical_frame")
    looked_up("left/tool0", "scene_camera_color_optical_frame")


def test_a_robot_s_wrench_is_in_its_own_frame(
    rospy: ModuleType, bringup: Bringup
) -> None:
    from geometry_msgs.msg import WrenchStamped
    from std_srvs.srv import Trigger

    with listening("/right/wrench", WrenchStamped) as received:
        assert received.next(30)[-1].header.frame_id == "right/tool0"
        assert call("/right/ur_hardware_interface/zero_ftsensor", Trigger).success
        force = received.next(80)[-1].wrench.force
    assert force.z == pytest.approx(0.0, abs=0.05)


# ---- the translation, without a bring-up ---------------------------------------------


def names_in(name: str, *robots: str) -> Any:
    """Return the namespace of one robot of a cell of bare arms."""
    from tool0.ros1.namespace import RosNamespace

    config = DescriptionConfig(
        robots=[f"{robot}=ur5@0,{i},0" for i, robot in enumerate(robots)],
        namespaces=True,
    )
    node: Any = SimpleNamespace(options=SimpleNamespace(root="/lab"))
    robot: Any = SimpleNamespace(description=load_description(config))
    return RosNamespace(node, robot, urdf="<robot/>", name=name, tf_prefix=name)


@pytest.mark.usefixtures("rospy")
def test_a_robot_does_not_own_the_names_of_one_with_a_longer_name() -> None:
    names = names_in("arm", "arm", "arm_2")
    assert names.name("joint_states") == "/lab/arm/joint_states"
    assert names.owns("arm_elbow_joint")
    assert not names.owns("arm_2_elbow_joint")
    assert {names.to_ros(joint.name) for joint in names.joints} >= set(ARM_JOINTS)
    assert len(names.joints) == len(names_in("arm_2", "arm", "arm_2").joints)
    assert not any(map(names_in("", "arm", "arm_2").owns, ("arm_x", "arm_2_x")))


@pytest.mark.usefixtures("rospy")
def test_own_and_full_names_undo_each_other() -> None:
    names = names_in("left", "left", "right")
    for full in (
        "left_elbow_joint",
        "left_left_inner_finger",
        "left_gripper_controller",
    ):
        assert names.to_model(names.to_ros(full)) == full
        assert names.text(f"unknown '{full}'") == f"unknown '{names.to_ros(full)}'"
    assert names.frame("left_left_inner_finger") == "left/left_inner_finger"
    assert names.frame("world") == "left/world"


@pytest.mark.usefixtures("rospy")
def test_a_camera_keeps_its_name_where_the_short_one_is_taken() -> None:
    names = names_in("left", "left", "right")
    cameras = [
        Camera(name=name, link=link, pose=Pose(), field_of_view=1.0)
        for name, link in (
            ("left_wrist", "left_tool0"),
            ("wrist", "left_forearm_link"),
            ("left_side", "left_tool0"),
            ("right_wrist", "right_tool0"),
            ("scene", None),
        )
    ]
    assert names.camera_names(cameras) == {
        "left_wrist": "left_wrist",
        "wrist": "wrist",
        "left_side": "side",
    }
    assert names_in("", "left", "right").camera_names(cameras) == {"scene": "scene"}


@pytest.mark.usefixtures("rospy")
def test_parameters_are_translated_both_ways() -> None:
    names = names_in("left", "left", "right")
    own = {
        "type": "any",
        "joints": ["elbow_joint", "wrist_1_joint"],
        "gains": {"elbow_joint": {"p": 1.0}},
    }
    full = {
        "type": "any",
        "joints": ["left_elbow_joint", "left_wrist_1_joint"],
        "gains": {"left_elbow_joint": {"p": 1.0}},
    }
    assert names.full_parameters(own) == full
    yaml = {
        "left_controller": full,
        "right_controller": {},
        "joint_limits": {"left_elbow_joint": 1, "right_elbow_joint": 2},
    }
    assert names.own_parameters(yaml) == {
        "controller": own,
        "joint_limits": {"elbow_joint": 1},
    }
    root = names_in("", "left", "right")
    assert set(root.own_parameters(yaml)) == {"joint_limits"}


def test_a_robot_alone_has_the_joints_of_the_cell_without_the_prefix(
    cell: Path,
) -> None:
    whole = load_description(DescriptionConfig(cell=cell))
    for robot in load_cell(cell).robots:
        alone = load_description(robot.description)
        expected = {robot.prefix + joint.name for joint in alone.model.joints}
        names = {joint.name for joint in whole.model.joints}
        assert expected == {n for n in names if n.startswith(robot.prefix)}
