"""The built-in controllers of a robot with <ros2_control>."""

from __future__ import annotations

from typing import Any

import pytest
import yaml
from raises_naming import raises_naming

from tool0.control.config import ControllerConfig
from tool0.control.default_controllers import controllers_yaml, default_controllers
from tool0.control.parameters import RobotJoints
from tool0.control.ros2.built_in import started
from tool0.description.config import DescriptionConfig
from tool0.description.loading import assemble, load_description
from tool0.description.parts import arm_joints
from tool0.description.robot import RobotDescription
from tool0.errors import ConfigError, DescriptionError

ARM = [
    *("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"),
    *("wrist_1_joint", "wrist_2_joint", "wrist_3_joint"),
]


def joints_of(description: RobotDescription) -> RobotJoints:
    model = description.model
    return RobotJoints(
        model.joint_by_name,
        {item.joint: item.interfaces for item in model.transmissions},
        hardware=model.hardware,
        grippers=model.grippers,
        speed_scaling={flange.removesuffix("tool0"): 1.0 for flange in model.flanges},
        arms=arm_joints(model),
    )


def parameters(text: str, node: str) -> dict[str, Any]:
    found: dict[str, Any] = yaml.safe_load(text)[node]["ros__parameters"]
    return found


@pytest.mark.parametrize(
    ("arm", "gripper", "rate"),
    [
        *(("ur5", "2f85", 125), ("ur3e", "2f140", 500), ("ur10", "hande", 125)),
        *(("ur20", None, 500), ("ur15", "2f85", 500)),
    ],
)
def test_every_one_can_be_configured(arm: str, gripper: str | None, rate: int) -> None:
    description = assemble(arm, gripper, ros2_control=True)
    config = default_controllers(description)
    assert config.dialect.name == "ros2"
    assert config.control_period == 1 / rate
    names = {*started().always, *started().built_in}
    if gripper is None:
        names = {name for name in names if "robotiq" not in name}
    assert names <= set(config.names)
    for name in config.names:
        config.spec(name, joints_of(description))
    movable = [joint.name for joint in description.model.movable_joints]
    assert config.lint(movable) == ()


def test_the_text_says_the_same_as_the_tree() -> None:
    description = assemble(ros2_control=True)
    text = controllers_yaml(description)
    config, tree = ControllerConfig.from_text(text), default_controllers(description)
    assert config.types == tree.types
    assert config.joint_limits() == tree.joint_limits()
    robot = joints_of(description)
    for name in config.names:
        assert config.spec(name, robot) == tree.spec(name, robot), name


def test_names_types_and_parameters_are_those_of_the_driver() -> None:
    text = controllers_yaml(assemble(ros2_control=True))
    manager = parameters(text, "controller_manager")
    assert manager["joint_trajectory_controller"] == {
        "type": "joint_trajectory_controller/JointTrajectoryController"
    }
    jtc = parameters(text, "joint_trajectory_controller")
    assert jtc["joints"] == ARM
    assert jtc["command_interfaces"] == ["position"]
    constraints = jtc["constraints"]
    assert (constraints["stopped_velocity_tolerance"], constraints["goal_time"]) == (
        *(0.2, 0.0),
    )
    assert all(constraints[j] == {"trajectory": 0.2, "goal": 0.1} for j in ARM)
    hand = parameters(text, "robotiq_gripper_controller")
    assert hand["joint"] == "finger_joint"
    assert hand["max_effort_interface"] == "finger_joint/set_gripper_max_effort"
    assert hand["goal_tolerance"] == 0.02
    for kind in ("position", "velocity", "effort"):
        forward = parameters(text, f"forward_{kind}_controller")
        assert (forward["interface_name"], forward["joints"]) == (kind, ARM)


def test_motions_of_tool0_have_their_limits() -> None:
    limits = default_controllers(assemble("ur5e", ros2_control=True)).joint_limits()
    assert limits == default_controllers(assemble("ur5e")).joint_limits()
    assert set(limits) == set(ARM)


def test_a_cell_has_them_for_each_robot() -> None:
    cell = ["left=ur5+2f85@0,0.6,0", "right=ur5e@0,-0.6,0"]
    config = DescriptionConfig(robots=cell, ros2_control=True)
    description = load_description(config)
    controllers = default_controllers(description)
    assert controllers.control_period == 1 / 500
    robot = joints_of(description)
    sensor = controllers.spec("left_force_torque_sensor_broadcaster", robot)
    assert sensor.state_interfaces[0] == "left_tcp_fts_sensor/force.x"
    arm = controllers.spec("right_joint_trajectory_controller", robot)
    assert arm.joints == tuple(f"right_{joint}" for joint in ARM)
    assert "left_robotiq_gripper_controller" in controllers.names
    assert "right_robotiq_gripper_controller" not in controllers.names
    assert "joint_state_broadcaster" in controllers.names


def test_a_cell_with_namespaces_has_a_broadcaster_for_each_robot() -> None:
    config = DescriptionConfig(
        robots=["left=ur5+2f85@0,0.6,0", "right=ur5e@0,-0.6,0"],
        namespaces=True,
        ros2_control=True,
    )
    description = load_description(config)
    controllers = default_controllers(description)
    assert "joint_state_broadcaster" not in controllers.names
    states = controllers.spec("left_joint_state_broadcaster", joints_of(description))
    assert "left_finger_joint/position" in states.state_interfaces
    assert all(state.startswith("left_") for state in states.state_interfaces)


def test_a_gripper_action_is_for_ros_1() -> None:
    with raises_naming(ConfigError, "gripper_action", "leave it out"):
        default_controllers(assemble(ros2_control=True), gripper_action=True)


def test_your_own_file_gets_them_if_it_has_an_arm(tmp_path: Any) -> None:
    known, unknown = tmp_path / "a.urdf", tmp_path / "b.urdf"
    text = assemble(ros2_control=True).urdf
    bare = assemble(gripper=None, ros2_control=True).urdf
    known.write_text(text.replace("elbow_joint", "knee_joint"))
    unknown.write_text(
        bare.replace("elbow_joint", "knee_joint")
        .replace('name="tool0"', 'name="end"')
        .replace('link="tool0"', 'link="end"')
    )
    own = load_description(DescriptionConfig(robot=known))
    assert "joint_trajectory_controller" in default_controllers(own).names
    assert "knee_joint: {trajectory: 0.2" in controllers_yaml(own)
    other = load_description(DescriptionConfig(robot=unknown))
    assert default_controllers(other).names == ()
    assert default_controllers(other).dialect.name == "ros2"
    with raises_naming(DescriptionError, str(unknown)):
        controllers_yaml(other)
