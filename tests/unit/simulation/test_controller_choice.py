"""Which controllers a robot of your own gets, and what is said if none fits."""

from pathlib import Path

import pytest

import tool0
from tool0.simulation.controllers import DEFAULT_CONTROLLERS

ROOT = Path(__file__).parents[3]
CELL = ROOT / "examples/cell"
INCLUDED = """<?xml version="1.0"?>
<robot name="my_cell" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:include filename="$(find tool0_description)/urdf/ur_robotiq.urdf.xacro"/>
  <link name="camera"/>
  <joint name="camera_joint" type="fixed">
    <parent link="tool0"/><child link="camera"/>
  </joint>
</robot>
"""
STILL = """<robot name="still"><link name="base">
  <inertial><mass value="1"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
</link></robot>
"""


def running(robot: tool0.Robot) -> list[str]:
    return [row.name for row in robot.controllers() if row.state == "running"]


@pytest.mark.parametrize("gripper", ["2f85", "none"])
def test_a_robot_with_the_joints_of_a_built_in_one_gets_its_controllers(
    gripper: str, tmp_path: Path
) -> None:
    cell = tmp_path / "my_cell.urdf.xacro"
    cell.write_text(INCLUDED)
    with tool0.bringup(robot=cell, args={"gripper": gripper}, realtime=False) as robot:
        n_default = 3 if gripper == "2f85" else 2
        assert running(robot) == list(DEFAULT_CONTROLLERS[:n_default])
        assert robot.warnings == ()
        (goal,) = robot.move_joints({"elbow_joint": -0.3}, duration=1.0)
        assert goal.wait(timeout=3.0).status is tool0.GoalStatus.SUCCEEDED


def test_other_interfaces_do_not_fit(tmp_path: Path) -> None:
    cell = tmp_path / "my_cell.urdf.xacro"
    cell.write_text(INCLUDED)
    args = {"transmission_hw_interface": "hardware_interface/PositionJointInterface"}
    with tool0.bringup(robot=cell, args=args, realtime=False) as robot:
        assert robot.controllers() == ()
        assert "no built-in one fits 'shoulder_pan_joint'" in robot.warnings[0]


def test_a_robot_that_fits_none_is_told_what_to_pass() -> None:
    with tool0.bringup(robot=CELL / "two_arms.urdf.xacro", realtime=False) as robot:
        (warning,) = robot.warnings
    assert "no controller is loaded" in warning
    assert "--controllers-file FILE" in warning
    assert "controllers_file=" in warning


def test_own_controllers_that_are_not_started_are_listed() -> None:
    with tool0.bringup(
        robot=CELL / "two_arms.urdf.xacro",
        controllers_file=CELL / "two_arms.yaml",
        realtime=False,
    ) as robot:
        (warning,) = robot.warnings
    assert "the YAML defines 'left_arm', 'right_arm'" in warning
    assert "--controllers 'NAME ...'" in warning


@pytest.mark.parametrize("controllers", ["", "joint_state_controller"])
def test_a_choice_is_not_warned_about(controllers: str) -> None:
    with tool0.bringup(controllers=controllers, realtime=False) as robot:
        assert running(robot) == controllers.split()
        assert robot.warnings == ()


def test_a_robot_without_a_driven_joint_is_reported(tmp_path: Path) -> None:
    file = tmp_path / "still.urdf"
    file.write_text(STILL)
    with tool0.bringup(robot=file, realtime=False) as robot:
        (warning,) = robot.warnings
    assert warning.startswith(f"{file}: the robot has no driven joint")


def test_all_robots_of_a_cell_start() -> None:
    robots = ("left=ur5+2f85@0,0.8,0", "right=ur3e@0,-0.8,0")
    description = tool0.DescriptionConfig(robots=robots)
    with tool0.bringup(description=description, realtime=False) as robot:
        assert running(robot) == [
            "joint_state_controller",
            "left_eff_joint_traj_controller",
            "left_gripper_controller",
            "right_eff_joint_traj_controller",
        ]
        assert robot.warnings == ()


def test_a_gripper_can_be_an_action_of_the_built_in_controllers_alone() -> None:
    control = tool0.ControlConfig(gripper_action=True)
    with tool0.bringup(control=control, realtime=False) as robot:
        kinds = {row.name: row.type for row in robot.controllers()}
    action = "effort_controllers/GripperActionController"
    assert kinds["gripper_controller"] == action
    with pytest.raises(tool0.ConfigError, match="gripper_action"):
        tool0.bringup(control=control, controllers_file=CELL / "two_arms.yaml")
