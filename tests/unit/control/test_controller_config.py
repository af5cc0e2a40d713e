import math
from pathlib import Path

import pytest
from toy_robot import ARM, JOINTS

from tool0.control.config import ControllerConfig
from tool0.control.controller_types import TYPES, parser_of
from tool0.control.gripper_action import GripperActionSpec
from tool0.control.joint_trajectory_spec import JointTrajectorySpec
from tool0.control.parameters import RobotJoints
from tool0.control.pid import Gains
from tool0.description.model import Interface, Joint, JointLimits, JointType
from tool0.errors import ConfigError, SourceLocation

DATA = Path(__file__).parents[2] / "data" / "controllers"
TOY = RobotJoints(JOINTS, dict.fromkeys(("hip", "slide", "wheel"), Interface.EFFORT))
ARM_JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
REAL = RobotJoints(
    {
        name: Joint(name=name, type=JointType.REVOLUTE, parent="x", child=name)
        for name in (*ARM_JOINTS, "finger_joint")
    },
    dict.fromkeys((*ARM_JOINTS, "finger_joint"), Interface.EFFORT),
)


def from_text(text: str) -> ControllerConfig:
    return ControllerConfig.from_text(text, SourceLocation(Path("c.yaml"), 1))


def test_reads_every_controller_of_a_real_file() -> None:
    config = ControllerConfig.from_files(DATA / "ur5_controllers.yaml")
    assert config.names == (
        "joint_state_controller",
        "eff_joint_traj_controller",
        "gripper_controller",
        "joint_group_eff_controller",
    )
    arm = config.spec("eff_joint_traj_controller", REAL)
    assert isinstance(arm, JointTrajectorySpec)
    assert arm.joints == ARM_JOINTS
    assert arm.gains[2] == Gains(p=2000.0, d=20.0, i=1.0, i_min=-1.0, i_max=1.0)
    assert arm.tolerances.goal_time == 0.6
    assert arm.tolerances.joints["elbow_joint"].goal == (0.1, 0.05, 0.0)
    assert arm.stop_trajectory_duration == 0.5
    assert arm.state_publish_rate == 125.0
    assert arm.action_monitor_rate == 10.0
    assert config.spec("joint_group_eff_controller", REAL).joints == ARM_JOINTS
    for name in config.names:
        assert config.spec(name, REAL).name == name


def test_reads_a_real_gripper_file() -> None:
    config = ControllerConfig.from_files(
        DATA / "robotiq_2f_85_gripper_controllers.yaml"
    )
    spec = config.spec("gripper_controller", REAL)
    assert isinstance(spec, GripperActionSpec)
    assert (spec.goal_tolerance, spec.max_effort) == (0.002, 100.0)
    assert not spec.allow_stalling


def test_later_files_override_key_by_key(tmp_path: Path) -> None:
    first, second = tmp_path / "a.yaml", tmp_path / "b.yaml"
    first.write_text(ARM)
    second.write_text("arm: {gains: {hip: {p: 7}}, joints: [hip, wheel]}\n")
    config = ControllerConfig.from_files([first, second])
    spec = config.spec("arm", TOY)
    assert isinstance(spec, JointTrajectorySpec)
    assert [gains.p for gains in spec.gains] == [7.0, 4000.0]
    assert spec.gains[0].d == 126.0


def test_slashes_aliases_merges_and_angles_are_those_of_rosparam() -> None:
    config = from_text(
        """
defaults: &slow {p: 1, d: 2, i_clamp: 3}
arm/type: effort_controllers/JointTrajectoryController
arm:
  joints: [hip, wheel]
  gains/hip: {<<: *slow, d: 4}
  gains: {wheel: *slow}
  constraints/hip/goal: !degrees 180
  constraints: {wheel: {goal: deg(90), trajectory: !radians 0.5}}
"""
    )
    spec = config.spec("arm", TOY)
    assert isinstance(spec, JointTrajectorySpec)
    assert spec.gains[0] == Gains(p=1.0, d=4.0, i_min=-3.0, i_max=3.0)
    assert spec.gains[1].d == 2.0
    assert spec.tolerances.joints["hip"].goal.position == pytest.approx(math.pi)
    assert spec.tolerances.joints["wheel"].goal.position == pytest.approx(math.pi / 2)
    assert spec.tolerances.joints["wheel"].path.position == 0.5


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        (
            "p: 4000",
            "p: abc",
            r"c.yaml:5: 'arm/gains/hip/p' must be a number, got 'abc'",
        ),
        ("p: 4000", "p: 1e3", r"YAML 1.1 writes that 1.0e\+03"),
        ("p: 4000", "p: .nan", "finite number, got nan"),
        ("p: 4000", "p: true", "must be a number, got True"),
        ("p: 4000, ", "", r"c.yaml:5: No p gain specified.*lacks 'p'"),
        ("gains:", "gians:", r"c.yaml:2: No p gain specified.*gains/hip/p"),
        (
            "gains: {hip:",
            "gains: {hop:",
            r"c.yaml:5: No p gain.*gains/hip/p.*did you mean 'hop'",
        ),
        (
            "joints: [hip, slide, wheel]",
            "joints: 5",
            "c.yaml:4: 'arm/joints' must be a list",
        ),
        ("joints: [hip, slide, wheel]", "joints: []", "must be a list"),
        ("joints: [hip, slide, wheel]", "joints: [hip, 3]", "must be a list of names"),
        ("joints: [hip, slide, wheel]", "joints: [hip, hip]", "joint 'hip' twice"),
        ("joints:", "joins:", "lacks 'joints'.*did you mean 'joins'"),
        ("goal_time: 0.5", "goal_time: -1", "goal_time' must be 0 or more, got -1"),
        ("constraints:", "constraints: 3 #", "not YAML"),
        (
            "stop_trajectory_duration: 0.5",
            "allow_partial_joints_goal: 1",
            "true or false",
        ),
    ],
)
def test_wrong_values_name_file_line_key_and_remedy(old, new, text) -> None:
    with pytest.raises(ConfigError, match=f"(?s){text}"):
        from_text(ARM.replace(old, new, 1)).spec("arm", TOY)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a:\n  b: [1,\nc: 2\n", "c.yaml:[34]: not YAML"),
        ("a: *nowhere\n", "c.yaml:1: not YAML.*undefined alias"),
        ("- a\n- b\n", "expected a mapping of parameters, got a list"),
        ("1: {type: x}\n", "key '1' under '/' must be a text"),
        ("a: !inch 3\n", "tag !inch"),
        ("a: !degrees far\n", "c.yaml:1: 'a' must be an angle"),
        ("a: &a [*a]\n", "contains itself"),
        ("a: {<<: 3}\n", "'<<' needs a mapping"),
    ],
)
def test_what_is_no_parameter_file_says_where(text: str, message: str) -> None:
    with pytest.raises(ConfigError, match=f"(?s){message}"):
        from_text(text)


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"none\.yaml: cannot read the file: No such"):
        ControllerConfig.from_files(tmp_path / "none.yaml")


def test_an_empty_text_has_no_controllers() -> None:
    assert from_text("").names == ()


def test_lines_count_on_from_where_the_text_stands() -> None:
    config = ControllerConfig.from_text(
        "\na: 5\n", SourceLocation(Path("outer.yaml"), 10)
    )
    with pytest.raises(
        ConfigError, match=r"outer\.yaml:11: 'a' is no controller, but 5"
    ):
        config.spec("a", TOY)


def test_a_key_that_stands_twice_is_a_warning() -> None:
    (warning,) = from_text("a: 1\nb: 2\na: 3\n").tree.findings
    assert (str(warning.location), warning.key) == ("c.yaml:3", "a")


def test_joint_limits_count_beside_their_flags() -> None:
    limits = from_text(
        """
joint_limits:
  hip: {has_velocity_limits: true, max_velocity: 2, max_effort: 5}
  slide: {has_position_limits: true, min_position: -1, max_position: 2}
  wheel: {has_effort_limits: false}
"""
    ).joint_limits()
    urdf = JointLimits(lower=-6.0, upper=6.0, velocity=3.0, effort=50.0)
    assert limits["hip"].over(urdf) == JointLimits(
        lower=-6.0, upper=6.0, velocity=2.0, effort=50.0
    )
    assert limits["slide"].over(urdf).lower == -1.0
    assert limits["wheel"].over(urdf).effort == math.inf
    assert from_text("a: 1").joint_limits() == {}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("hip: 3", "'joint_limits/hip' must be a mapping"),
        ("hip: {has_velocity_limits: true}", "lacks 'max_velocity'"),
        (
            "hip: {has_position_limits: true, min_position: 2, max_position: 1}",
            "min_position 2.0 above max_position 1.0",
        ),
    ],
)
def test_wrong_joint_limits_are_errors(text: str, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        from_text(f"joint_limits: {{{text}}}").joint_limits()


@pytest.mark.parametrize("type_name", TYPES)
def test_every_type_has_a_parser(type_name: str) -> None:
    assert callable(parser_of(type_name))
