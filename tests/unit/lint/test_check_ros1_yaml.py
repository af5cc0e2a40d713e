"""Rules for ros_control's YAML, without and with a robot."""

import re

import pytest
import yaml
from check_files import DATA, of_yaml, summary

from tool0.control.ros1.dialect import ROS1
from tool0.description.loading import assemble
from tool0.description.xml_source import parse_text
from tool0.lint.robot.elements import Tag
from tool0.lint.robot.facts import RobotFacts, facts_of

ARM = """\
arm:
  type: effort_controllers/JointTrajectoryController
  joints: [elbow_joint, wrist_1_joint]
  gains:
    elbow_joint: {p: 2000, d: 20, i: 1, i_clamp: 1}
    wrist_1_joint: {p: 500, d: 1, i: 1, i_clamp: 1}
"""
PUBLISHED = yaml.safe_load(
    (DATA / "checks" / "published_controllers.yaml").read_text(encoding="utf-8")
)


@pytest.fixture(scope="module")
def robot() -> RobotFacts:
    root = parse_text(assemble().urdf).documentElement
    assert root is not None
    return facts_of(Tag(root))


@pytest.mark.slow
def test_a_good_file_is_clean(robot: RobotFacts) -> None:
    assert of_yaml(ARM) == of_yaml(ARM, robot) == []


@pytest.mark.parametrize("arm", PUBLISHED["noetic_controller_defaults"]["per_model"])
def test_what_is_published_is_clean(arm: str, robot: RobotFacts) -> None:
    defaults = PUBLISHED["noetic_controller_defaults"]
    gripper = {k: v for k, v in defaults["gripper_2f85"].items() if k != "source"}
    joints = list(defaults["per_model"][arm]["gains"])
    text = yaml.safe_dump(
        {
            "joint_state_controller": {
                "type": "joint_state_controller/JointStateController",
                "publish_rate": defaults["loop_hz_publish"],
            },
            "eff_joint_traj_controller": {
                "type": "effort_controllers/JointTrajectoryController",
                "joints": joints,
                **defaults["per_model"][arm],
            },
            "joint_group_eff_controller": {
                "type": "effort_controllers/JointGroupEffortController",
                "joints": joints,
            },
            "gripper_controller": gripper,
        },
        sort_keys=False,
    )
    assert of_yaml(text) == of_yaml(text, robot) == []


FOLLOWER = "left_inner_knuckle_joint,"
LAST = "    wrist_1_joint: {p: 500, d: 1, i: 1, i_clamp: 1}\n"
OF_ROS2 = "joint_trajectory_controller/"


@pytest.mark.parametrize(
    ("old", "new", "line", "rule", "says"),
    [
        ("elbow_joint,", "elbw_joint,", 3, "unknown-joint", "'elbow_joint'"),
        ("elbow_joint,", "finger_joint,", 5, "unread-key", "'elbow_joint'"),
        ("elbow_joint,", FOLLOWER, 3, "no-transmission", "'finger_joint'"),
        ("effort_c", "velocity_c", 3, "interface-mismatch", "EffortJointInterface"),
        (LAST, "", 4, "missing-gains", "gains/wrist_1_joint: {p:"),
        ("{p: 500, d", "{d", 6, "missing-gains", "{p:"),
        ("TrajectoryC", "TrajectoriC", 2, "unknown-type", "JointTrajectoryController"),
        ("effort_controllers/", OF_ROS2, 2, "unknown-type", "ROS 2"),
        ("p: 2000", "p: many", 5, "controller-fails", "'many'"),
        ("  joints: [elbow_joint, wrist_1_joint]\n", "", 1, "missing-key", "joints"),
        ("i_clamp: 1}", "i_clam: 1}", 5, "unread-key", "'i_clamp'"),
    ],
)
def test_what_is_wrong_is_named_where_it_stands(
    robot: RobotFacts, *, old: str, new: str, line: int, rule: str, says: str
) -> None:
    assert old in ARM
    found = of_yaml(ARM.replace(old, new, 1), robot)
    matching = [f for f in found if (f.location.line, f.rule) == (line, rule)]
    assert matching, [str(finding) for finding in found]
    assert says in str(matching[0])


def test_lost_indentation_is_one_finding_and_the_rest_is_read_all_the_same() -> None:
    flat = re.sub(r"^  (?=\w)", "", ARM.replace("p: 500, ", ""), flags=re.MULTILINE)
    found = of_yaml(flat)
    assert summary(found) == [
        (1, "flat-yaml", "arm"),
        (6, "missing-gains", "arm/gains/wrist_1_joint"),
    ]
    assert "'type' after it is not indented" in found[0].message


def test_joints_of_an_unknown_robot_are_not_judged() -> None:
    text = ARM.replace("elbow_joint", "knee").replace("wrist_1_joint", "toe")
    assert of_yaml(text) == []


def test_other_nodes_parameters_are_their_own() -> None:
    assert of_yaml(f"{ARM}\nmove_base:\n  recovery: true\n  rate: 3\n") == []
    (finding,) = of_yaml(f"{ARM}\nother:\n  typ: x/yController\n  joints: [a]\n")
    assert finding.remedy == "is 'typ' meant to be 'type'?"
    assert finding.severity == "error"
    (finding,) = of_yaml(f"{ARM}\nmy_node:\n  joints: [a]\n  gains: [1]\n")
    assert (finding.rule, finding.severity) == ("no-type", "warning")


def test_what_only_tool0_does_otherwise_is_no_fault_of_the_file() -> None:
    assert of_yaml("gazebo_ros_control: {pid_gains: {elbow_joint: {p: 1}}}") == []


@pytest.mark.parametrize("name", sorted(ROS1.types))
def test_every_type_is_known(name: str) -> None:
    assert not [f for f in of_yaml(f"c: {{type: {name}}}") if f.rule == "unknown-type"]


@pytest.mark.parametrize(
    "name",
    [
        "diff_drive_controller/DiffDriveController",
        "pass_through_controllers/JointTrajectoryController",
        "position_controllers/CartesianTrajectoryController",
    ],
)
def test_types_of_others_are_let_be(name: str) -> None:
    assert of_yaml(f"c: {{type: {name}, anything: 1}}") == []


@pytest.mark.parametrize(
    ("name", "severity"),
    [
        ("my_package/MyController", "warning"),
        ("effort_controllers/CartesianTrajectoryController", "warning"),
        ("my_controllers/JointTrajectoryController", "warning"),
        ("effort_controler/JointTrajectoryController", "error"),
        ("effort_controllers/jointtrajectorycontroller", "error"),
        ("JointTrajectoryController", "error"),
    ],
)
def test_an_unknown_type_is_an_error_only_if_it_is_misspelt(
    name: str, severity: str
) -> None:
    (finding,) = of_yaml(f"{ARM}\nc: {{type: {name}}}")
    assert (finding.rule, finding.severity) == ("unknown-type", severity)


@pytest.mark.parametrize(
    ("line", "severity"),
    [
        ("  stop_trajectory_durations: 0.1\n", "error"),
        ("  own_setting_of_this_robot: 0.1\n", "warning"),
        ("  goal_time: 0.1\n", "warning"),
    ],
)
def test_an_unknown_key_is_an_error_only_if_it_is_misspelt(
    line: str, severity: str
) -> None:
    (finding,) = of_yaml(ARM + line)
    assert (finding.rule, finding.severity) == ("unread-key", severity)


def test_a_robot_without_transmissions_is_driven_by_its_own_program() -> None:
    text = re.sub("(?s)<transmission.*?</transmission>", "", assemble().urdf)
    root = parse_text(text).documentElement
    assert root is not None
    assert of_yaml(ARM, facts_of(Tag(root))) == []


def test_what_moveit_reads_is_no_controller_without_a_type() -> None:
    moveit = "controller_list:\n  - {name: arm, type: FollowJointTrajectory}\n"
    assert of_yaml(f"{ARM}\n{moveit}") == []
    assert of_yaml(f"{ARM}\n{moveit.replace('_list', '_lisp')}") != []


def test_a_fixed_joint_is_not_what_was_meant() -> None:
    text = """
    <robot name="r"><link name="a"/><link name="b"/><link name="c"/>
    <joint name="right_outer_finger_joint" type="fixed">
      <parent link="a"/><child link="b"/></joint>
    <joint name="right_finger_joint" type="continuous">
      <parent link="b"/><child link="c"/></joint></robot>
    """
    robot = parse_text(text).documentElement
    assert robot is not None
    gains = "ros_control:\n  pid_gains:\n    right_outer_knuckle_joint: {p: 1}\n"
    unknown = [
        f for f in of_yaml(gains, facts_of(Tag(robot))) if f.rule == "unknown-joint"
    ]
    assert [item.remedy for item in unknown] == ["did you mean 'right_finger_joint'?"]


def test_yaml_on_one_line_is_read_too() -> None:
    text = "arm: {type: effort_controllers/JointEffortController, a: 1, b: 2, joint: j}"
    assert summary(of_yaml(text)) == [
        (1, "unread-key", "arm/a"),
        (1, "unread-key", "arm/b"),
    ]
