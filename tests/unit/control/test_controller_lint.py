import re
from pathlib import Path

import pytest
from toy_robot import ARM, JOINTS

from tool0.control.config import ControllerConfig
from tool0.control.controller_types import TYPES, parameters_of
from tool0.control.lint import lint
from tool0.description.model import Joint, JointType, RobotModel

DATA = Path(__file__).parents[2] / "data" / "controllers"


def model(*joints: Joint) -> RobotModel:
    return RobotModel(name="toy", root="x", links=(), joints=joints)


TOY = model(*JOINTS.values())
GRIPPER = model(
    *(
        Joint(name=name, type=JointType.REVOLUTE, parent="x", child=name)
        for name in (
            "finger_joint",
            "left_inner_knuckle_joint",
            "left_inner_finger_joint",
            "right_inner_knuckle_joint",
            "right_inner_finger_joint",
            "right_finger_joint",
        )
    )
)


def found(text: str, robot: RobotModel | None = TOY) -> list[tuple[str, str]]:
    warnings = lint(ControllerConfig.from_text(text), robot)
    return [(item.key, item.text) for item in warnings]


def test_the_gripper_file_is_clean() -> None:
    path = DATA / "robotiq_2f_85_gripper_controllers.yaml"
    assert lint(ControllerConfig.from_files(path), GRIPPER) == ()


def test_the_arm_file_has_exactly_the_four_keys_of_another_controller() -> None:
    path = DATA / "ur5_controllers.yaml"
    warnings = lint(ControllerConfig.from_files(path))
    assert [(item.location.line, item.key) for item in warnings] == [
        (41, "gripper_controller/goal_tolerance"),
        (42, "gripper_controller/max_effort"),
        (43, "gripper_controller/stall_velocity_threshold"),
        (44, "gripper_controller/stall_timeout"),
    ]
    for item in warnings:
        assert item.location.file == path
        assert "GripperActionController only" in item.message


def test_the_gazebo_file_is_read_by_nothing() -> None:
    path = DATA / "gazebo_controller.yaml"
    warnings = lint(ControllerConfig.from_files(path), GRIPPER)
    assert [(item.location.line, item.key) for item in warnings] == [
        (3, "ros_control/pid_gains"),
        (7, "ros_control/pid_gains/right_outer_knuckle_joint"),
    ]
    assert "'gazebo_ros_control/pid_gains'" in warnings[0].remedy
    assert "no joint 'right_outer_knuckle_joint'" in warnings[1].message
    assert "'right_finger_joint'" in warnings[1].remedy  # the only one not yet named


def test_a_good_controller_gives_no_warning() -> None:
    assert found(ARM) == []


@pytest.mark.parametrize(
    ("old", "new", "key", "text"),
    [
        ("goal_time:", "goal_tim:", "arm/constraints/goal_tim", "'goal_time'"),
        ("hip: {tr", "hop: {tr", "arm/constraints/hop", "no joint 'hop'.*'hip'"),
        ("hip: {tr", "idle: {tr", "arm/constraints/idle", "not among the controller's"),
        ("trajectory: 0.1", "trajectry: 1", "arm/constraints/hip/trajectry", "'trajec"),
        ("i_clamp: 1", "i_clam: 1", "arm/gains/hip/i_clam", "'i_clamp'"),
        ("i_clamp: 1", "i_clamp: 0", "arm/gains/hip/i", "contributes nothing.* is 0"),
        ("stop_traj", "stop_trj", "arm/stop_trjectory_duration", "'stop_trajectory_d"),
        ("effort_c", "position_c", "arm/gains", "no use for gains"),
    ],
)
def test_a_key_that_nothing_reads_is_named_with_the_nearest(
    old: str, new: str, key: str, text: str
) -> None:
    messages = dict(found(ARM.replace(old, new, 1)))
    assert re.search(text, messages[key])


def test_a_key_at_the_wrong_place_says_where_it_belongs() -> None:
    assert "indent" in dict(found("gains: {hip: {p: 1}}"))["gains"]
    assert "'typ' meant to be 'type'" in dict(found("arm: {typ: x}"))["arm"]


def test_gazebos_own_gains_are_said_to_be_gazebos() -> None:
    text = "gazebo_ros_control: {pid_gains: {hip: {p: 1}}}"
    assert "Gazebo's" in dict(found(text))["gazebo_ros_control/pid_gains"]


def test_limits_without_their_flag_and_unknown_ones_are_named() -> None:
    messages = dict(
        found("joint_limits: {hip: {max_velocity: 2, has_efort_limits: true}, hop: {}}")
    )
    assert "has_velocity_limits: true" in messages["joint_limits/hip/max_velocity"]
    assert "has_effort_limits" in messages["joint_limits/hip/has_efort_limits"]
    assert "no joint 'hop'" in messages["joint_limits/hop"]


@pytest.mark.parametrize(("flag", "is_told"), [("true", True), ("false", False)])
def test_an_acceleration_limit_that_nothing_enforces_is_told(
    flag: str, is_told: bool
) -> None:
    limits = f"{{has_acceleration_limits: {flag}, max_acceleration: 9}}"
    messages = dict(found(f"joint_limits: {{hip: {limits}}}"))
    text = messages.get("joint_limits/hip/max_acceleration", "")
    assert ("no drive of tool0 enforces it" in text) is is_told


def test_without_a_model_no_joint_is_unknown() -> None:
    assert not any(
        "no joint" in text for _, text in found("joint_limits: {hop: {}}", None)
    )


@pytest.mark.parametrize("type_name", TYPES)
def test_the_linter_knows_the_parameters_of_every_type(type_name: str) -> None:
    assert parameters_of(type_name)
