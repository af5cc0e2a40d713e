"""The built-in controllers: parts of arms and grippers, for one robot or a cell."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import pytest
import yaml
from raises_naming import raises_naming

import tool0
from tool0.control.controller_parts import CATALOGUE_JOINTS
from tool0.control.default_controllers import controllers_yaml, default_controllers
from tool0.control.parameters import RobotJoints
from tool0.description.catalogue import find_part
from tool0.description.config import Cell, CellRobot, DescriptionConfig
from tool0.description.loading import assemble, load_description, load_robot
from tool0.description.robot import RobotDescription
from tool0.errors import ConfigError, DescriptionError

DATA = Path(__file__).parents[2] / "data"
CONTROLLERS = [
    "joint_state_controller",
    "eff_joint_traj_controller",
    "joint_group_eff_controller",
    "gripper_controller",
]
DERIVED = "ur10e"


def own_arm(folder: Path, *, gains: str | None = None) -> RobotDescription:
    """Return a copy of the default arm with other gains, or none."""
    shutil.copytree(find_part("arm", "ur5").folder, folder)
    (folder / "gains.yaml").unlink()
    if gains is not None:
        (folder / "gains.yaml").write_text(gains)
    return assemble(str(folder), None)


def joints_named_in(text: str) -> set[str]:
    return {
        token.value
        for token in yaml.scan(text)
        if isinstance(token, yaml.ScalarToken) and token.value.endswith("_joint")
    }


def robot_joints(description: RobotDescription) -> RobotJoints:
    model = description.model
    interfaces = {item.joint: item.interfaces for item in model.transmissions}
    return RobotJoints(model.joint_by_name, interfaces)


def parsed(description: RobotDescription, **options: Any) -> dict[str, Any]:
    content: dict[str, Any] = yaml.safe_load(controllers_yaml(description, **options))
    return content


def cell(controllers_file: Path | None = None) -> RobotDescription:
    """Return two robots, of which the right one may have its own controllers."""
    left = CellRobot(name="left", description=DescriptionConfig(base_xyz=(0, 0.8, 0)))
    right = CellRobot(
        name="right",
        description=DescriptionConfig(arm=DERIVED, base_xyz=(0, -0.8, 0)),
        controllers_file=controllers_file,
    )
    return load_description(DescriptionConfig(cell=Cell(robots=(left, right))))


@pytest.mark.parametrize("gripper_action", [False, True])
def test_controllers_name_the_driven_joints(gripper_action: bool) -> None:
    description = assemble()
    text = controllers_yaml(description, gripper_action=gripper_action)
    assert joints_named_in(text) == set(description.model.transmission_by_joint)
    assert list(yaml.safe_load(text)) == CONTROLLERS


def test_a_robot_without_gripper_has_no_controller_for_one() -> None:
    text = controllers_yaml(assemble(gripper=None))
    assert list(yaml.safe_load(text)) == CONTROLLERS[:-1]
    assert "finger_joint" not in joints_named_in(text)


def test_a_prefix_reaches_every_joint_and_no_controller() -> None:
    plain = controllers_yaml(assemble())
    text = controllers_yaml(assemble(prefix="left_"))
    expected = {f"left_{name}" for name in joints_named_in(plain)}
    assert joints_named_in(text) == expected
    assert text.replace("left_", "") == plain


def test_robots_of_a_cell_have_controllers_of_their_own() -> None:
    content = parsed(cell())
    assert list(content) == [
        "joint_state_controller",
        *(f"left_{name}" for name in CONTROLLERS[1:]),
        *(f"right_{name}" for name in CONTROLLERS[1:]),
        "joint_limits",
    ]
    left = content["left_eff_joint_traj_controller"]
    alone = parsed(assemble(prefix="left_"))["eff_joint_traj_controller"]
    assert left == alone
    assert set(content["joint_limits"]) == {
        joint for joint in joints_named_in(str(content)) if joint.startswith("right_")
    } - {"right_finger_joint"}


OWN = """
joint_state_controller:
  type: joint_state_controller/JointStateController
  publish_rate: 50

my_arm:
  type: position_controllers/JointTrajectoryController
  joints: [shoulder_pan_joint]
joint_limits:
  elbow_joint: {has_velocity_limits: true, max_velocity: 0.5}
"""


def test_a_robot_of_a_cell_may_have_its_own_controllers(tmp_path: Path) -> None:
    file = tmp_path / "own.yaml"
    file.write_text(OWN)
    description = cell(file)
    content = parsed(description)
    assert list(content) == [
        "joint_state_controller",
        *(f"left_{name}" for name in CONTROLLERS[1:]),
        "right_my_arm",
        "joint_limits",
    ]
    assert content["joint_state_controller"]["publish_rate"] == 125
    assert content["right_my_arm"]["joints"] == ["right_shoulder_pan_joint"]
    assert content["joint_limits"]["right_elbow_joint"]["max_velocity"] == 0.5
    config = default_controllers(description)
    assert config.parameters() == content
    with raises_naming(ConfigError, f"{file}:8", "right_shoulder_pan_joint"):
        config.spec("right_my_arm", robot_joints(description))


def test_each_robot_with_a_namespace_has_a_joint_state_controller() -> None:
    robots = ("left=ur5+2f85@0,0.5,0", "right=ur5@0,-0.5,0")
    config = DescriptionConfig(robots=robots, namespaces=True)
    description = load_description(config)
    content = parsed(description)
    assert "joint_state_controller" not in content
    for name, gripper in (("left", ["finger_joint"]), ("right", [])):
        published = content.pop(f"{name}_joint_state_controller")["joints"]
        arm = content[f"{name}_eff_joint_traj_controller"]["joints"]
        assert published == sorted([*arm, *(f"{name}_{joint}" for joint in gripper)])
    alike = load_description(DescriptionConfig(robots=robots))
    assert content == {
        name: value
        for name, value in parsed(alike).items()
        if name != "joint_state_controller"
    }
    config_alike = default_controllers(description)
    assert config_alike.parameters() == parsed(description)


@pytest.mark.slow
@pytest.mark.parametrize("gripper_action", [False, True])
def test_what_is_printed_is_what_runs(gripper_action: bool) -> None:
    for description in (assemble(), assemble(DERIVED), cell()):
        printed = parsed(description, gripper_action=gripper_action)
        config = default_controllers(description, gripper_action=gripper_action)
        assert config.parameters() == printed


def test_every_gain_has_its_derivation_beside_it() -> None:
    for arm, said in (("ur5", "ur_gazebo"), (DERIVED, "kg·m²")):
        lines = controllers_yaml(assemble(arm)).splitlines()
        gains = [line for line in lines if "{p: " in line]
        assert len(gains) == 7
        comments = [line.partition("  # ")[2] for line in gains]
        assert all(said in comment for comment in comments[:6])
        assert comments[6]


def test_the_default_robot_has_the_gains_of_its_folders() -> None:
    content = parsed(assemble())
    pan = content["eff_joint_traj_controller"]["gains"]["shoulder_pan_joint"]
    assert pan == {"p": 4000, "i": 20000, "d": 60, "i_clamp": 20, "antiwindup": True}
    finger = content["gripper_controller"]["gains"]["finger_joint"]
    assert finger == {"p": 600, "i": 0, "d": 5.4}
    assert "joint_limits" not in content


def test_a_folder_may_state_the_gains_of_some_joints(tmp_path: Path) -> None:
    text = "source: measured\ngains:\n  elbow_joint: {p: 1234}\n"
    content = parsed(own_arm(tmp_path / "mine", gains=text))
    gains = content["eff_joint_traj_controller"]["gains"]
    assert gains["elbow_joint"] == {"p": 1234}
    assert gains["wrist_1_joint"]["d"] > 0
    assert "elbow_joint" not in content["joint_limits"]


@pytest.mark.parametrize(
    ("gains", "line", "named"),
    [
        ("source: x\ngains:\n  elbow: {p: 1}\n", 3, "'elbow_joint'"),
        ("source: x\ngains:\n  elbow_joint: {p: much}\n", 3, "elbow_joint/p"),
        ("gains: {}\n", 1, "source"),
        ("source: x\ngain: {}\n", 2, "'gains'"),
    ],
)
def test_wrong_gains_are_told_with_file_and_line(
    tmp_path: Path, gains: str, line: int, named: str
) -> None:
    description = own_arm(tmp_path / "mine", gains=gains)
    place = f"{tmp_path / 'mine' / 'gains.yaml'}:{line}"
    with raises_naming(ConfigError, place, named):
        config = default_controllers(description)
        config.spec("eff_joint_traj_controller", robot_joints(description))


def test_the_payload_counts_if_it_is_known(tmp_path: Path) -> None:
    own_arm(tmp_path / "mine")
    file = tmp_path / "mine" / "specifications.yaml"
    file.unlink()
    unknown = controllers_yaml(assemble(str(tmp_path / "mine"), None))
    assert "without payload" in unknown
    file.write_text("specifications: {payload: 5.0, reach: 0.85}\n")
    assert "with 5 kg" in controllers_yaml(assemble(str(tmp_path / "mine"), None))
    file.write_text("specifications: {payload: heavy}\n")
    with raises_naming(DescriptionError, f"{file}:1", "payload"):
        controllers_yaml(assemble(str(tmp_path / "mine"), None))


def test_two_arms_of_your_own_file_have_controllers_of_their_names() -> None:
    mine = parsed(load_robot(DATA / "description" / "two_robots.urdf.xacro"))
    for side in ("left", "right"):
        arm = mine[f"{side}_eff_joint_traj_controller"]
        joints = [f"{side}_{joint}" for joint in CATALOGUE_JOINTS]
        assert arm["joints"] == list(arm["gains"]) == joints
        assert arm["constraints"][f"{side}_elbow_joint"] == {
            "trajectory": 0.1,
            "goal": 0.1,
        }
        assert mine[f"{side}_gripper_controller"]["joints"] == [f"{side}_finger_joint"]


def test_a_robot_without_an_arm_has_no_built_in_controllers(tmp_path: Path) -> None:
    path = tmp_path / "still.urdf"
    path.write_text('<robot name="still"><link name="base"/></robot>')
    description = load_robot(path)
    with raises_naming(DescriptionError, str(path)):
        controllers_yaml(description)
    assert default_controllers(description).names == ()


def test_your_own_file_with_the_usual_joints_gets_gains_of_its_model(
    tmp_path: Path,
) -> None:
    file = tmp_path / "mine.urdf"
    file.write_text(assemble(DERIVED).urdf)
    mine = parsed(load_robot(file))
    assert list(mine) == [*CONTROLLERS, "joint_limits"]
    p = mine["eff_joint_traj_controller"]["gains"]["shoulder_lift_joint"]["p"]
    assert p > 20000  # a UR5's is 10000


def test_ros2_controllers_need_no_interface_that_the_robot_lacks(
    tmp_path: Path,
) -> None:
    urdf = assemble(ros2_control=True).urdf
    bare = re.sub(r'<command_interface name="(set_gripper|reactivate)\w+"/>', "", urdf)
    assert bare != urdf
    for text, expected in ((urdf, True), (bare, False)):
        file = tmp_path / "robot.urdf"
        file.write_text(text)
        yaml_text = controllers_yaml(load_robot(file))
        assert ("max_effort_interface: finger_joint" in yaml_text) is expected
        assert "robotiq_gripper_controller" in yaml_text
        with tool0.bringup(robot=file, realtime=False) as robot:
            running = {item.name for item in robot.controllers() if item.is_running}
            assert "robotiq_gripper_controller" in running
