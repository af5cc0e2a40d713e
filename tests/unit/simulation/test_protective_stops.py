"""What stops an arm by itself, once its safety limits are enabled."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import pytest
from ur5_rig import ARM, ARM_JOINTS, AWAY

import tool0
from tool0 import TrajectoryPoint
from tool0.description.config import DescriptionConfig
from tool0.description.scene import SceneObject
from tool0.description.shapes import Sphere
from tool0.description.transform import Pose
from tool0.errors import ControlError
from tool0.protocol.arm_motion import ExecutePath, ReturnArm, TakeArm
from tool0.protocol.control_box_state import ProgramState, SafetyMode
from tool0.protocol.goals import GoalResult
from tool0.simulation.config import ControlConfig

INTERFACE = "hardware_interface/PositionJointInterface"
GROUP = """
group:
  type: position_controllers/JointGroupPositionController
  joints: [shoulder_pan_joint, shoulder_lift_joint, elbow_joint, wrist_1_joint,
           wrist_2_joint, wrist_3_joint]
"""
OVER_TABLE = Pose(xyz=(0.45, 0.15, 0.2), rpy=(math.pi, 0.0, 0.0))
IN_TABLE = Pose(xyz=(0.45, 0.15, -0.1), rpy=(math.pi, 0.0, 0.0))
DRIVE_AT_LIMIT = "no contact: the drive of 'shoulder_pan_joint' gives all of its 150"
STRONG = (0.0, 0.0, 400.0)
"""[N·m]; the joint at the base has 150."""


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False, scene="table_and_cubes") as robot:
        robot.arm.move_to(OVER_TABLE).wait(10.0)
        robot.run(0.2)
        yield robot


def reason(robot: tool0.Robot) -> str:
    state = robot.arm.control_box.state
    is_stopped = state.safety_mode is SafetyMode.PROTECTIVE_STOP
    assert is_stopped == bool(state.protective_stop)
    return state.protective_stop


def test_a_contact_with_too_much_force_stops_the_arm(robot: tool0.Robot) -> None:
    robot.arm.control_box.set_safety_limits(enabled=True)
    goal = robot.arm.move_linear(IN_TABLE, speed=0.1, collision="ignore")
    robot.run(0.3)
    assert not reason(robot)
    goal.wait(5.0)
    assert "at 'tool0', more than 150 N" in reason(robot)
    assert "touches 'table'" in reason(robot)
    assert "protective stop" in next(
        status.blocked for status in robot.snapshot.controllers if status.name == ARM
    )
    robot.run(0.2)
    height = robot.arm.pose().position[2]
    robot.run(0.5)
    assert robot.arm.pose().position[2] == pytest.approx(height, abs=1e-4)


def test_the_force_limit_can_be_set(robot: tool0.Robot) -> None:
    robot.arm.control_box.set_safety_limits(enabled=True, force=30.0)
    robot.arm.move_linear(IN_TABLE, speed=0.1, collision="ignore").wait(5.0)
    assert "more than 30 N" in reason(robot)


@pytest.mark.slow
def test_nothing_stops_by_itself_unless_enabled(robot: tool0.Robot) -> None:
    robot.arm.move_linear(IN_TABLE, speed=0.25, collision="ignore")
    robot.run(1.0)
    robot.apply_wrench("upper_arm_link", torque=STRONG)
    robot.run(0.5)
    assert not reason(robot)


def test_a_grip_is_no_collision(robot: tool0.Robot) -> None:
    box, gripper = robot.arm.control_box, robot.gripper
    box.set_safety_limits(enabled=True, force=50.0)
    names = [item.name for item in robot.snapshot.scene]
    cube = robot.snapshot.objects[names.index("red cube")]
    over = Pose(xyz=(*cube.position[:2], 0.15), rpy=(math.pi, 0.0, 0.0))
    at = Pose(xyz=cube.position, rpy=(math.pi, 0.0, 0.0))
    tool = gripper.tcp(0.04)
    assert robot.arm.move_to(over, tool=tool).wait(10.0)
    robot.run(0.3)
    assert robot.arm.move_linear(at, tool=tool).wait(10.0)
    assert gripper.move(opening=0.0, force=200.0).wait(5.0)
    robot.run(0.3)
    assert gripper.state.motion == "holding_inside"
    assert robot.arm.move_linear(over, tool=tool).wait(10.0)
    assert not reason(robot)


def test_a_path_error_stops_the_arm(robot: tool0.Robot) -> None:
    robot.arm.control_box.set_safety_limits(enabled=True)
    robot.apply_wrench("upper_arm_link", torque=STRONG)
    robot.run(1.0)
    assert "off its path, more than 0.157 rad (no contact" in reason(robot)
    assert DRIVE_AT_LIMIT in reason(robot)


def test_a_goal_that_fails_names_the_same_cause(robot: tool0.Robot) -> None:
    arm = robot.controller(ARM)
    others = dict.fromkeys(ARM_JOINTS, -1.0)
    goal = arm.follow(
        [TrajectoryPoint(AWAY, time_from_start=5.0)],
        path_tolerance={**others, "shoulder_pan_joint": 0.05},
    )
    robot.apply_wrench("upper_arm_link", torque=STRONG)
    goal.wait(5.0)
    assert isinstance(goal.result, GoalResult)
    assert "shoulder_pan_joint path error" in goal.result.error_string
    assert DRIVE_AT_LIMIT in goal.result.error_string


def test_a_command_beyond_a_limit_stops_the_arm(tmp_path: Path) -> None:
    file = tmp_path / "controllers.yaml"
    file.write_text(GROUP)
    with tool0.bringup(
        description=DescriptionConfig(transmission_hw_interface=INTERFACE),
        control=ControlConfig(controllers_file=file, controllers="group"),
        realtime=False,
    ) as robot:
        robot.arm.control_box.set_safety_limits(enabled=True)
        held = {**robot.arm.joints, "elbow_joint": 3.5}  # its limit is pi
        robot.controller("group").command([*held.values()])
        robot.run(0.1)
        assert "joint 'elbow_joint' is commanded to 3.5 rad" in reason(robot)


def test_an_emergency_stop_is_none(robot: tool0.Robot) -> None:
    robot.arm.control_box.set_safety_limits(enabled=True)
    robot.move_joints({"shoulder_pan_joint": 2.0}, speed=1.0)
    robot.run(0.4)
    robot.emergency_stop()
    robot.run(0.5)
    robot.emergency_stop(False)
    robot.run(0.5)
    assert not reason(robot)


@pytest.mark.slow
def test_a_program_that_has_the_arm_loses_it(robot: tool0.Robot) -> None:
    box, call = robot.arm.control_box, robot.channel.call
    box.set_safety_limits(enabled=True)
    call(TakeArm(by="a program"))
    positions = robot.arm.inverse_kinematics(IN_TABLE)[0].positions
    there = tuple(positions[name] for name in robot.arm.joint_names)
    rest = ((0.0,) * 6,)
    call(ExecutePath(times=(1.0,), positions=(there,), velocities=rest))
    robot.run(2.0)
    assert "touches 'table'" in reason(robot)
    assert box.state.taken_by == ""
    with pytest.raises(ControlError, match="protective stop"):
        call(TakeArm(by="a program"))
    call(ReturnArm())
    robot.run(5.0)
    box.unlock()
    call(TakeArm(by="a program"))
    call(ReturnArm())
    assert box.state.program is ProgramState.STOPPED
    box.play()
    assert robot.arm.move_to(OVER_TABLE).wait(10.0)


def test_a_payload_is_no_collision() -> None:
    """10 kg are carried if they are expected, and stop the arm if they are not."""
    with tool0.bringup(arm="ur10e", realtime=False) as robot:
        box, flange = robot.arm.control_box, robot.pose("tool0")
        tool = box.state.payload.mass
        robot.channel.call(TakeArm(by="a program"))  # which holds by servos
        box.set_payload(tool + 10.0, (0.0, 0.0, 0.3))
        robot.scene.add(
            SceneObject(
                name="part",
                geometry=Sphere(radius=0.02),
                pose=Pose(xyz=flange.apply((0.0, 0.0, 0.3))),
                mass=10.0,
            )
        )
        robot.engine.world.attach("part", "tool0")
        robot.run(0.5)
        box.set_safety_limits(enabled=True, force=50.0)
        robot.run(1.0)
        assert not reason(robot)
        box.clear_payload()
        robot.run(1.0)
        assert "N at 'tool0', more than 50 N" in reason(robot)
