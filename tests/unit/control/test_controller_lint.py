from pathlib import Path

import pytest
from toy_robot import ARM, JOINTS

from tool0.control.config import ControllerConfig
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

GRIPPER_JOINTS = [joint.name for joint in GRIPPER.movable_joints]

Found = dict[str, tuple[str, str]]


def found(text: str, robot: RobotModel | None = TOY) -> Found:
    """Return rule and remedy of each finding, by key."""
    joints = None if robot is None else [j.name for j in robot.movable_joints]
    findings = lint(ControllerConfig.from_text(text), joints)
    return {item.key: (item.rule, item.remedy) for item in findings}


def test_the_gripper_file_is_clean() -> None:
    path = DATA / "robotiq_2f_85_gripper_controllers.yaml"
    assert lint(ControllerConfig.from_files(path), GRIPPER_JOINTS) == ()


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
        assert (item.location.file, item.rule) == (path, "misplaced-key")
        assert "GripperActionController" in item.message


def test_the_gazebo_file_is_read_by_nothing() -> None:
    path = DATA / "gazebo_controller.yaml"
    warnings = lint(ControllerConfig.from_files(path), GRIPPER_JOINTS)
    assert [(item.location.line, item.key) for item in warnings] == [
        (3, "ros_control/pid_gains"),
        (7, "ros_control/pid_gains/right_outer_knuckle_joint"),
    ]
    assert [item.rule for item in warnings] == ["misplaced-key", "unknown-joint"]
    assert "'right_finger_joint'" in warnings[1].remedy  # the only one not yet named


def test_a_good_controller_gives_no_warning() -> None:
    assert found(ARM) == {}


@pytest.mark.parametrize(
    ("old", "new", "key", "rule", "near"),
    [
        ("goal_time:", "goal_tim:", "constraints/goal_tim", "unread-key", "goal_time"),
        ("hip: {tr", "hop: {tr", "constraints/hop", "unknown-joint", "hip"),
        ("hip: {tr", "idle: {tr", "constraints/idle", "unread-key", "slide"),
        (
            "trajectory: 0.1",
            "trajectry: 1",
            "constraints/hip/trajectry",
            "unread-key",
            "trajectory",
        ),
        ("i_clamp: 1", "i_clam: 1", "gains/hip/i_clam", "unread-key", "i_clamp"),
        ("i_clamp: 1", "i_clamp: 0", "gains/hip/i", "idle-integral", "i_clamp"),
        (
            "stop_traj",
            "stop_trj",
            "stop_trjectory_duration",
            "unread-key",
            "stop_trajectory_duration",
        ),
        ("effort_c", "position_c", "gains", "misplaced-key", ""),
    ],
)
def test_a_key_that_nothing_reads_is_named_with_the_nearest(
    old: str, new: str, *, key: str, rule: str, near: str
) -> None:
    assert found(ARM) == {}
    said, remedy = found(ARM.replace(old, new, 1))[f"arm/{key}"]
    assert said == rule
    assert near in remedy


@pytest.mark.parametrize(
    ("text", "key", "rule", "named"),
    [
        ("gains: {hip: {p: 1}}", "gains", "flat-yaml", ""),
        ("arm: {typ: x}", "arm", "no-type", "'typ'"),
        (
            "gazebo_ros_control: {pid_gains: {hip: {p: 1}}}",
            "gazebo_ros_control/pid_gains",
            "gazebo-only",
            "",
        ),
        (
            "joint_limits: {hip: {has_efort_limits: true}}",
            "joint_limits/hip/has_efort_limits",
            "unread-key",
            "'has_effort_limits'",
        ),
        (
            "joint_limits: {hip: {max_velocity: 2}}",
            "joint_limits/hip/max_velocity",
            "limit-without-flag",
            "",
        ),
        ("joint_limits: {hop: {}}", "joint_limits/hop", "unknown-joint", "'hip'"),
        (
            "joint_limits: {hip: {has_jerk_limits: true, max_jerk: 9}}",
            "joint_limits/hip/max_jerk",
            "not-enforced",
            "",
        ),
    ],
)
def test_what_is_no_controller_is_judged_by_its_key(
    text: str, key: str, rule: str, named: str
) -> None:
    said, remedy = found(text)[key]
    assert said == rule
    assert named in remedy


def test_a_limit_that_is_switched_off_need_not_be_enforced() -> None:
    text = "joint_limits: {hip: {has_jerk_limits: false, max_jerk: 9}}"
    assert found(text) == {}


def test_without_a_model_no_joint_is_unknown() -> None:
    assert found("joint_limits: {hop: {}}", None) == {}
