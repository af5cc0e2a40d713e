import pytest
from toy_robot import ARM, JOINTS
from ur5_rig import CONTROLLERS, POST, POST_GRIPPER

from tool0.control.config import ControllerConfig
from tool0.control.ros1.lint import lint
from tool0.description.loading import assemble
from tool0.description.model import RobotModel

TOY = RobotModel(name="toy", root="x", links=(), joints=tuple(JOINTS.values()))
UR5 = [joint.name for joint in assemble().model.movable_joints]
Found = dict[str, tuple[str, str]]


def found(text: str, robot: RobotModel | None = TOY) -> Found:
    """Return rule and remedy of each finding, by key."""
    joints = None if robot is None else [j.name for j in robot.movable_joints]
    findings = lint(ControllerConfig.from_text(text).tree, joints)
    return {item.key: (item.rule, item.remedy) for item in findings}


def test_good_files_are_clean() -> None:
    assert lint(ControllerConfig.from_files(POST_GRIPPER).tree, UR5) == ()
    assert found(ARM) == {}


def test_the_arm_file_has_exactly_the_four_keys_of_another_controller() -> None:
    warnings = lint(ControllerConfig.from_files(POST).tree)
    lines = POST.read_text().splitlines()
    assert len(warnings) == 4
    for item in warnings:
        assert (item.location.file, item.rule) == (POST, "misplaced-key")
        controller, key = item.key.split("/")
        assert controller == "gripper_controller"
        assert lines[item.location.line - 1].strip().startswith(f"{key}:")
        assert "GripperActionController" in item.message


def test_the_gazebo_file_is_read_by_nothing() -> None:
    path = CONTROLLERS / "gazebo_controller.yaml"
    warnings = lint(ControllerConfig.from_files(path).tree, UR5)
    assert [(item.location.line, item.key) for item in warnings] == [
        (3, "ros_control/pid_gains"),
        (7, "ros_control/pid_gains/right_outer_knuckle_joint"),
    ]
    assert [item.rule for item in warnings] == ["misplaced-key", "unknown-joint"]
    assert "'right_finger_joint'" in warnings[1].remedy  # the only one not yet named


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
    ],
)
def test_what_is_no_controller_is_judged_by_its_key(
    text: str, key: str, rule: str, named: str
) -> None:
    said, remedy = found(text)[key]
    assert said == rule
    assert named in remedy


def test_what_is_right_or_cannot_be_judged_is_not_told() -> None:
    assert found("joint_limits: {hip: {has_jerk_limits: true, max_jerk: 9}}") == {}
    assert found("joint_limits: {hop: {}}", None) == {}
