"""Rules for ros2_control's YAML."""

import pytest
import yaml
from check_files import DATA, of_yaml

from tool0.description.xml_source import parse_text
from tool0.lint.robot.elements import Tag
from tool0.lint.robot.facts import RobotFacts, facts_of

GOOD = """\
controller_manager:
  ros__parameters:
    update_rate: 500
    joint_state_broadcaster:
      type: joint_state_broadcaster/JointStateBroadcaster
    arm:
      type: joint_trajectory_controller/JointTrajectoryController
    gripper:
      type: position_controllers/GripperActionController
arm:
  ros__parameters:
    joints: [elbow_joint, wrist_1_joint]
    command_interfaces: [position]
    state_interfaces: [position, velocity]
    constraints:
      goal_time: 0.0
      elbow_joint: {trajectory: 0.2, goal: 0.1}
gripper:
  ros__parameters:
    joint: finger_joint
    stall_timeout: 0.5
"""
ROBOT = """
<robot name="r">
  <joint name="elbow_joint" type="revolute"/>
  <joint name="wrist_1_joint" type="revolute"/>
  <joint name="finger_joint" type="revolute"/>
  <joint name="idle" type="revolute"/>
  <ros2_control name="s" type="system">
    <joint name="elbow_joint"><command_interface name="position"/></joint>
    <joint name="wrist_1_joint"><command_interface name="position"/></joint>
    <joint name="finger_joint"><command_interface name="position"/></joint>
  </ros2_control>
</robot>
"""


@pytest.fixture(scope="module")
def robot() -> RobotFacts:
    root = parse_text(ROBOT).documentElement
    assert root is not None
    return facts_of(Tag(root))


def test_a_good_file_is_clean(robot: RobotFacts) -> None:
    assert of_yaml(GOOD) == of_yaml(GOOD, robot) == []


def test_a_node_of_any_namespace_is_found() -> None:
    assert of_yaml(f"/robot:\n{'  '.join(['', *GOOD.splitlines(True)])}") == []


def test_what_is_published_is_clean() -> None:
    published = PUBLISHED["ros2_sim_controller_defaults"]
    arm = dict(published["jtc"])
    per_joint = arm.pop("per_joint")
    joints = ["shoulder_pan_joint", "elbow_joint"]
    arm["constraints"] = {
        "stopped_velocity_tolerance": arm.pop("stopped_velocity_tolerance"),
        "goal_time": arm.pop("goal_time"),
        **dict.fromkeys(joints, per_joint),
    }
    gripper = dict(published["gripper_sim"])
    types = {
        "arm": {"type": "joint_trajectory_controller/JointTrajectoryController"},
        "gripper": {"type": gripper.pop("type")},
    }
    rate = published["controller_manager_update_rate_hz"]
    nodes = {
        "controller_manager": {"update_rate": rate, **types},
        "arm": {"joints": joints, **arm},
        "gripper": {"joint": "finger_joint", **gripper},
    }
    text = yaml.safe_dump({k: {"ros__parameters": v} for k, v in nodes.items()})
    assert of_yaml(text) == []


PUBLISHED = yaml.safe_load(
    (DATA / "checks" / "published_controllers.yaml").read_text(encoding="utf-8")
)


@pytest.mark.parametrize(
    ("old", "new", "line", "rule", "says"),
    [
        ("update_rate", "update_rat", 3, "unread-key", "'update_rate'"),
        ("TrajectoryController", "TrajectoryControler", 7, "unknown-type", "did you"),
        ("joint_trajectory_", "effort_", 7, "unknown-type", "effort_controller/"),
        ("gripper:\n  ros", "griper:\n  ros", 18, "no-controller", "'gripper'"),
        ("arm:\n  ros__p", "arm:\n  ros_p", 11, "no-ros-parameters", "ros__parameters"),
        ("    joints: [elbow_joint, wrist_1_joint]\n", "", 10, "missing-key", "joints"),
        ("stall_timeout", "stall_timout", 21, "unread-key", "'stall_timeout'"),
        ("goal_time", "goal_tim", 16, "unread-key", "'goal_time'"),
        ("elbow_joint,", "elbw_joint,", 12, "unknown-joint", "'elbow_joint'"),
        ("elbow_joint,", "idle,", 12, "no-transmission", "<ros2_control>"),
        ("[position]", "[effort]", 13, "missing-gains", "closes the loop"),
        ("[position]", "[velocity]", 12, "interface-mismatch", "offers position"),
        ("    constr", "    max_effort: 1\n    constr", 15, "misplaced-key", ""),
    ],
)
def test_what_is_wrong_is_named_where_it_stands(
    robot: RobotFacts, *, old: str, new: str, line: int, rule: str, says: str
) -> None:
    assert old in GOOD
    found = of_yaml(GOOD.replace(old, new, 1), robot)
    matching = [f for f in found if (f.location.line, f.rule) == (line, rule)]
    assert matching, [str(finding) for finding in found]
    assert says in str(matching[0])


def test_a_missing_level_is_told_once() -> None:
    text = "controller_manager:\n  arm: {type: pid_controller/PidController}\n"
    (finding,) = of_yaml(text)
    assert (finding.rule, finding.location.line) == ("no-ros-parameters", 1)


def test_a_key_that_no_known_version_reads_is_suspicious_only() -> None:
    (finding,) = of_yaml(GOOD.replace("stall_timeout: 0.5", "colour: red"))
    assert (finding.rule, finding.severity) == ("unread-key", "warning")


def test_a_dot_in_a_key_is_a_level() -> None:
    line = "    constraints.wrist_1_joint: {trajectory: 0.2, GOAL: 0.1}\n"
    before = "    constraints:\n"
    assert before in GOOD
    good = GOOD.replace(before, line.replace("GOAL", "goal") + before, 1)
    assert of_yaml(good) == []
    assert of_yaml(GOOD.replace(before, line + before, 1)) != []


@pytest.mark.parametrize(
    "name", ["my_package/MyController", "ur_controllers/ForceModesBroadcaster"]
)
def test_a_type_that_no_package_exports_is_suspicious_only(name: str) -> None:
    (finding,) = of_yaml(
        f"controller_manager:\n  ros__parameters:\n    c: {{type: {name}}}\n"
    )
    assert (finding.rule, finding.severity) == ("unknown-type", "warning")


def test_a_similar_key_is_an_error_only_if_it_is_misspelt() -> None:
    for key, severity in (("stalltimeout", "error"), ("stall_time", "warning")):
        found = of_yaml(GOOD.replace("stall_timeout", key))
        assert [f.severity for f in found] == [severity], key
