"""Which controllers a robot of your own gets, and what is said if none fits."""

import re
from pathlib import Path

import pytest

import tool0
from tool0.description.loading import assemble, load_robot

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
LIFT = STILL.replace("still", "lifted").replace(
    "</robot>",
    """<link name="table"><inertial><mass value="1"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <joint name="lift" type="prismatic"><parent link="base"/><child link="table"/>
    <axis xyz="0 0 1"/><limit lower="0" upper="1" effort="99" velocity="1"/></joint>
  <transmission name="t"><type>transmission_interface/SimpleTransmission</type>
    <joint name="lift">
      <hardwareInterface>hardware_interface/PositionJointInterface</hardwareInterface>
    </joint><actuator name="m"/></transmission>
</robot>""",
)


def running(robot: tool0.Robot) -> list[str]:
    return [row.name for row in robot.controllers() if row.is_running]


@pytest.mark.parametrize("gripper", ["2f85", "none"])
def test_a_robot_with_the_joints_of_a_built_in_one_gets_its_controllers(
    gripper: str, tmp_path: Path
) -> None:
    cell = tmp_path / "my_cell.urdf.xacro"
    cell.write_text(INCLUDED)
    with tool0.bringup(robot=cell, args={"gripper": gripper}, realtime=False) as robot:
        expected = ["joint_state_controller", "eff_joint_traj_controller"]
        hand = ["gripper_controller"] if gripper == "2f85" else []
        assert running(robot) == expected + hand
        assert robot.warnings == ()
        (goal,) = robot.move_joints({"elbow_joint": -0.3}, duration=1.0)
        assert goal.wait(timeout=3.0).status is tool0.GoalStatus.SUCCEEDED


@pytest.mark.parametrize("gripper", ["2f85", "hande"])
def test_a_built_in_robot_gets_controllers_for_its_interface(gripper: str) -> None:
    position = "hardware_interface/PositionJointInterface"
    description = tool0.DescriptionConfig(
        gripper=gripper, transmission_hw_interface=position
    )
    with tool0.bringup(description=description, realtime=False) as robot:
        assert running(robot) == [
            "joint_state_controller",
            "pos_joint_traj_controller",
            "gripper_controller",
        ]
        (goal,) = robot.move_joints({"elbow_joint": 1.2}, duration=1.0)
        assert goal.wait(timeout=3.0).status is tool0.GoalStatus.SUCCEEDED
        robot.gripper.move(opening=0.03)
        assert robot.gripper.wait(timeout=3.0).motion == "at_target"
        assert robot.gripper.opening == pytest.approx(0.03, abs=1e-3)
    with pytest.raises(tool0.ConfigError, match="has hardware_interface/Position"):
        tool0.bringup(
            description=description,
            control=tool0.ControlConfig(gripper_action=True),
        )


@pytest.mark.parametrize("prefix", ["", "my_"])
def test_an_arm_of_your_own_gets_controllers_for_its_interface(
    tmp_path: Path, prefix: str
) -> None:
    cell = tmp_path / "my_cell.urdf.xacro"
    cell.write_text(INCLUDED.replace('"tool0"', f'"{prefix}tool0"'))
    args = {
        "transmission_hw_interface": "hardware_interface/PositionJointInterface",
        "prefix": prefix,
    }
    with tool0.bringup(robot=cell, args=args, realtime=False) as robot:
        assert running(robot) == [
            "joint_state_controller",
            "pos_joint_traj_controller",
            "gripper_controller",
        ]
        assert robot.warnings == ()
        (goal,) = robot.move_joints({f"{prefix}elbow_joint": -0.3}, duration=1.0)
        assert goal.wait(timeout=3.0).status is tool0.GoalStatus.SUCCEEDED


@pytest.mark.parametrize("ros2", [False, True])
def test_each_of_several_arms_of_your_own_gets_controllers(
    tmp_path: Path, ros2: bool
) -> None:
    file = CELL / "two_arms.urdf.xacro"
    if ros2:  # the drives are assumed
        document = load_robot(file).urdf
        file = tmp_path / "two_arms.urdf"
        file.write_text(
            re.sub(r"<transmission .*?</transmission>", "", document, flags=re.DOTALL)
        )
    name = "joint_trajectory_controller" if ros2 else "pos_joint_traj_controller"
    with tool0.bringup(robot=file, ros2_control=ros2, realtime=False) as robot:
        assert {f"left_{name}", f"right_{name}"} <= set(running(robot))
        goals = robot.move_joints({"left_elbow_joint": -0.3, "right_elbow_joint": -0.3})
        for goal in goals:
            assert goal.wait(timeout=9.0).status is tool0.GoalStatus.SUCCEEDED


def test_an_arm_without_a_flange_moves_in_ros2_too(tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    text = assemble(gripper=None, ros2_control=True).urdf
    file.write_text(text.replace('"tool0"', '"end"'))
    with tool0.bringup(robot=file, realtime=False) as robot:
        (goal,) = robot.move_joints({"elbow_joint": -0.3}, duration=1.0)
        assert goal.wait(timeout=3.0).status is tool0.GoalStatus.SUCCEEDED


def test_a_robot_that_fits_none_is_told_what_to_pass(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    file = tmp_path / "lift.urdf"
    file.write_text(LIFT)
    with tool0.bringup(robot=file, realtime=False) as robot:
        (warning,) = robot.warnings
    assert "no built-in one fits 'lift'" in warning
    assert "--controllers-file FILE" in warning
    assert "controllers_file=" in warning
    assert warning in caplog.text


def test_own_controllers_that_drive_a_joint_alone_are_started(tmp_path: Path) -> None:
    with tool0.bringup(
        robot=CELL / "two_arms.urdf.xacro",
        controllers_file=CELL / "two_arms.yaml",
        realtime=False,
    ) as robot:
        assert running(robot) == [
            "left_arm",
            "right_arm",
            "left_gripper",
            "right_gripper",
        ]
        assert robot.warnings == ()


CONTROLLER = "{}: {{type: {}_controllers/{}, joints: [lift]{}}}\n"
PATH, FAST, GROUP = (
    CONTROLLER.format("path", "position", "JointTrajectoryController", ""),
    CONTROLLER.format("fast", "position", "JointTrajectoryController", ""),
    CONTROLLER.format("group", "position", "JointGroupPositionController", ""),
)
EFFORT = CONTROLLER.format(
    "effort", "effort", "JointTrajectoryController", ", gains: {lift: {p: 1}}"
)
STATES = (
    "states: {type: joint_state_controller/JointStateController, publish_rate: 50}\n"
)
USUAL = STATES.replace("states", "joint_state_controller", 1)


@pytest.mark.parametrize(
    ("text", "started", "warning"),
    [
        (STATES + PATH + GROUP, ["states", "path"], ""),
        (USUAL + PATH + GROUP, ["joint_state_controller", "path"], ""),
        (GROUP + EFFORT, ["group"], ""),
        (
            PATH + FAST + GROUP,
            [],
            "'path', 'fast' all drive 'lift', and none is started",
        ),
        (PATH.replace("lift", "lft"), [], "'path' cannot be started"),
    ],
)
def test_what_is_not_started_is_said(
    text: str, started: list[str], warning: str, tmp_path: Path
) -> None:
    robot_file, controllers = tmp_path / "lift.urdf", tmp_path / "controllers.yaml"
    robot_file.write_text(LIFT)
    controllers.write_text(text)
    with tool0.bringup(
        robot=robot_file, controllers_file=controllers, realtime=False
    ) as robot:
        assert running(robot) == started
        assert warning in "".join(robot.warnings)
        assert bool(robot.warnings) == bool(warning)


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
