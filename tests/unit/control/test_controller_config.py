import math
from dataclasses import replace
from pathlib import Path

import pytest
from raises_naming import raises_naming
from toy_robot import ARM, JOINTS
from ur5_rig import ARM_JOINTS, POST, POST_GRIPPER

from tool0.control.config import ControllerConfig
from tool0.control.gripper_action import GripperActionSpec
from tool0.control.joint_limits import joint_limit_parameters
from tool0.control.parameters import RobotJoints
from tool0.control.ros1.dialect import ROS1
from tool0.control.ros1.joint_trajectory import JointTrajectorySpec
from tool0.description.loading import assemble
from tool0.description.model import Interface, JointLimits
from tool0.errors import ConfigError, SourceLocation
from tool0.protocol.controllers import Gains

OFFERED = (Interface.EFFORT,)
TOY = RobotJoints(JOINTS, dict.fromkeys(("hip", "slide", "wheel"), OFFERED))
UR5 = assemble().model.joint_by_name
REAL = RobotJoints(UR5, dict.fromkeys(UR5, OFFERED))


def from_text(text: str) -> ControllerConfig:
    return ControllerConfig.from_text(text, SourceLocation(Path("c.yaml"), 1))


def test_reads_every_controller_of_a_real_file() -> None:
    config = ControllerConfig.from_files(POST)
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
    config = ControllerConfig.from_files(POST_GRIPPER)
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


def refused(text: str, name: str = "arm") -> tuple[int | None, str]:
    """Return the line and the text of the error that loading a controller raises."""
    with pytest.raises(ConfigError) as error:
        from_text(text).spec(name, TOY)
    location = error.value.location
    assert location is not None
    assert location.file == Path("c.yaml")
    return location.line, str(error.value)


@pytest.mark.parametrize(
    ("old", "new", "line", "named"),
    [
        ("p: 4000", "p: abc", 5, ("arm/gains/hip/p", "'abc'")),
        ("p: 4000", "p: 1e3", 5, ("arm/gains/hip/p", "1.0e+03")),
        ("p: 4000", "p: .nan", 5, ("arm/gains/hip/p", "nan")),
        ("p: 4000", "p: true", 5, ("arm/gains/hip/p", "True")),
        ("p: 4000, ", "", 5, ("arm/gains/hip", "'p'")),
        ("gains:", "gians:", 2, ("gains/hip/p",)),
        ("gains: {hip:", "gains: {hop:", 5, ("gains/hip/p", "'hop'")),
        ("joints: [hip, slide, wheel]", "joints: 5", 4, ("arm/joints",)),
        ("joints: [hip, slide, wheel]", "joints: []", 4, ("arm/joints",)),
        ("joints: [hip, slide, wheel]", "joints: [hip, 3]", 4, ("arm/joints",)),
        ("joints: [hip, slide, wheel]", "joints: [hip, hip]", 4, ("'hip'",)),
        ("joints:", "joins:", 2, ("'joints'", "'joins'")),
        ("goal_time: 0.5", "goal_time: -1", None, ("goal_time", "-1")),
        (
            "stop_trajectory_duration: 0.5",
            "allow_partial_joints_goal: 1",
            None,
            ("allow_partial_joints_goal", "1"),
        ),
    ],
)
def test_wrong_values_name_file_line_and_key(
    old: str, new: str, line: int | None, named: tuple[str, ...]
) -> None:
    found, text = refused(ARM.replace(old, new, 1))
    assert line in (None, found)
    assert all(name in text for name in named), text


@pytest.mark.parametrize(
    ("text", "line", "named"),
    [
        ("a: {b: 1}\nc: 3 # \n d: 4\n", 3, ""),
        ("a: *nowhere\n", 1, "alias"),
        ("- a\n- b\n", 1, "list"),
        ("\n1: {type: x}\n", 2, "'1'"),
        ("a: !inch 3\n", 1, "!inch"),
        ("a: !degrees far\n", 1, "'far'"),
        ("a: &a [*a]\n", 1, "'a[0]'"),
        ("a: {<<: 3}\n", 1, "<<"),
    ],
)
def test_what_is_no_parameter_file_says_where(text: str, line: int, named: str) -> None:
    found, message = refused(text)
    assert (found, named in message) == (line, True), message


def test_a_file_that_does_not_exist_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as error:
        ControllerConfig.from_files(tmp_path / "none.yaml")
    assert error.value.location == SourceLocation(tmp_path / "none.yaml")


def test_lines_count_on_from_where_the_text_stands() -> None:
    place = SourceLocation(Path("outer.yaml"), 10)
    with pytest.raises(ConfigError) as error:
        ControllerConfig.from_text("\na: 5\n", place).spec("a", TOY)
    assert error.value.location == SourceLocation(Path("outer.yaml"), 11)


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
    assert replace(urdf, **limits["hip"]) == JointLimits(
        lower=-6.0, upper=6.0, velocity=2.0, effort=50.0
    )
    assert limits["slide"]["lower"] == -1.0
    assert limits["wheel"]["effort"] == math.inf
    assert from_text("").joint_limits() == {}
    assert from_text("").names == ()


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("hip: 3", ("joint_limits/hip",)),
        ("hip: {has_velocity_limits: true}", ("joint_limits/hip", "max_velocity")),
        (
            "hip: {has_position_limits: true, min_position: 2, max_position: 1}",
            ("joint_limits/hip", "2.0", "1.0"),
        ),
    ],
)
def test_wrong_joint_limits_are_errors(text: str, named: tuple[str, ...]) -> None:
    with raises_naming(ConfigError, *named):
        from_text(f"joint_limits: {{{text}}}").joint_limits()


@pytest.mark.parametrize("type_name", sorted(ROS1.types))
def test_every_type_has_a_parser_that_names_its_parameters(type_name: str) -> None:
    assert ROS1.parameters_of(type_name) & {"joint", "joints"}


def test_known_parameters_are_those_that_the_parsers_look_up() -> None:
    trajectory = ROS1.parameters_of("effort_controllers/JointTrajectoryController")
    assert {"gains/*/p", "velocity_ff/*", "constraints/*/goal"} <= trajectory
    assert "gains/*/publish_state" in trajectory  # of ROS only
    positions = ROS1.parameters_of("position_controllers/JointTrajectoryController")
    assert trajectory - positions == {
        item for item in trajectory if item.startswith(("gains/", "velocity_ff/"))
    }
    assert ROS1.readers_of("stall_timeout") == ("GripperActionController",)
    assert {"max_jerk", "has_effort_limits"} <= joint_limit_parameters()
