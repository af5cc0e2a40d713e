"""Grippers of published robot files."""

from __future__ import annotations

from pathlib import Path

import pytest

import tool0
from tool0.description.loading import assemble, load_robot
from tool0.description.xml_source import parse_text

INERTIAL = (
    '<inertial><mass value="0.2"/><inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" '
    'iyz="0" izz="1e-3"/></inertial>'
)


def robot_text(joint: str, upper: float) -> str:
    return f"""<robot name="hand">
  <link name="base"/>
  <link name="knuckle">{INERTIAL}</link>
  <link name="other">{INERTIAL}</link>
  <joint name="{joint}" type="revolute"><parent link="base"/><child link="knuckle"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="{upper}" effort="50" velocity="2"/>
  </joint>
  <joint name="right_{joint}" type="revolute"><parent link="base"/><child link="other"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="{upper}" effort="50" velocity="2"/>
    <mimic joint="{joint}"/></joint>
</robot>"""


@pytest.mark.parametrize(
    ("joint", "upper", "name", "model"),
    [
        ("finger_joint", 0.8, "gripper", "2f85"),
        ("finger_joint", 0.7, "gripper", "2f140"),
        ("robotiq_85_left_knuckle_joint", 0.8, "gripper", "2f85"),
        ("left_robotiq_85_left_knuckle_joint", 0.8, "left_gripper", "2f85"),
    ],
)
def test_a_gripper_is_known_by_the_name_of_its_joint(
    joint: str, upper: float, name: str, model: str, tmp_path: Path
) -> None:
    file = tmp_path / "hand.urdf"
    file.write_text(robot_text(joint, upper))
    description = load_robot(file)
    (gripper,) = description.model.grippers
    (expected,) = assemble(gripper=model).model.grippers
    assert (gripper.name, gripper.joint) == (name, joint)
    assert gripper.law == expected.law
    assert gripper.max_opening == expected.max_opening
    # other processes get it with the URDF
    root = parse_text(description.urdf).documentElement
    assert root is not None
    assert len(root.getElementsByTagName("parallel_gripper")) == 1


@pytest.mark.parametrize("has_controllers", [False, True])
def test_it_can_be_commanded_by_its_opening(
    tmp_path: Path, has_controllers: bool
) -> None:
    file = tmp_path / "hand.urdf"
    file.write_text(robot_text("robotiq_85_left_knuckle_joint", 0.8))
    controllers = tmp_path / "controllers.yaml"
    controllers.write_text("""
controller_manager:
  ros__parameters:
    hand: {type: position_controllers/GripperActionController}
hand:
  ros__parameters: {joint: robotiq_85_left_knuckle_joint}
""")
    with tool0.bringup(
        robot=file,
        ros2_control=True,
        controllers_file=controllers if has_controllers else None,
        realtime=False,
    ) as robot:
        robot.gripper.move(opening=0.04)
        robot.gripper.wait()
        assert robot.gripper.opening == pytest.approx(0.04, abs=1e-3)


def test_other_joints_are_no_grippers(tmp_path: Path) -> None:
    file = tmp_path / "hand.urdf"
    file.write_text(robot_text("thumb_joint", 0.8))
    assert load_robot(file).model.grippers == ()
