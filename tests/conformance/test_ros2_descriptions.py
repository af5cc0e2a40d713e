"""Robots whose drives ``<ros2_control>`` describes: they hold, and follow commands."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conformance_types import BringUp

import tool0

SMALL_ARM = Path("tests/data/description/ros2_arm.urdf.xacro")
START = {"left_pan_joint": 0.2, "left_lift_joint": -0.5, "left_bend_joint": 0.9}
FINGERS = ["left_left_finger_joint", "left_right_finger_joint"]
UR_JOINTS = (
    *("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"),
    *("wrist_1_joint", "wrist_2_joint", "wrist_3_joint"),
)
CONTROLLERS = """
moving:
  type: position_controllers/JointTrajectoryController
  joints: [{joints}]
  constraints: {{goal_time: 2.0, stopped_velocity_tolerance: 0.05}}
turning:
  type: velocity_controllers/JointGroupVelocityController
  joints: [{turned}]
"""


@pytest.fixture
def small_arm(bring_up: BringUp, tmp_path: Path) -> tool0.Robot:
    joints = ", ".join([*START, FINGERS[0]])
    text = CONTROLLERS.format(joints=joints, turned="left_pan_joint")
    file = tmp_path / "controllers.yaml"
    file.write_text(text)
    return bring_up(
        robot=SMALL_ARM,
        args={"tf_prefix": "left_"},
        controllers_file=file,
        controllers=["moving"],
        stopped_controllers=["turning"],
    )


def positions(robot: tool0.Robot) -> dict[str, float]:
    snapshot = robot.snapshot
    return dict(zip(snapshot.joint_names, snapshot.position, strict=True))


def test_it_starts_and_holds_where_its_description_says(small_arm: tool0.Robot) -> None:
    expected = {**START, **dict.fromkeys(FINGERS, 0.03)}
    for _ in range(2):
        assert positions(small_arm) == pytest.approx(expected, abs=1e-4)
        small_arm.run(1.0)
    assert np.abs(small_arm.snapshot.velocity).max() < 1e-3


def test_it_follows_positions(small_arm: tool0.Robot) -> None:
    target = {"left_pan_joint": -0.6, "left_bend_joint": 0.4, FINGERS[0]: 0.01}
    for goal in small_arm.move_joints(target):
        assert goal.wait(10.0).error_code == 0
    small_arm.run(0.5)
    reached = positions(small_arm)
    assert {name: reached[name] for name in target} == pytest.approx(target, abs=1e-3)
    assert reached[FINGERS[1]] == pytest.approx(0.01, abs=2e-3)


def test_it_turns_at_a_velocity_through_the_other_interface(
    small_arm: tool0.Robot,
) -> None:
    small_arm.switch(start=["turning"], stop=["moving"])
    small_arm.controller("turning").command([0.4])
    small_arm.run(0.5)
    velocity = dict(
        zip(small_arm.snapshot.joint_names, small_arm.snapshot.velocity, strict=True)
    )
    assert velocity["left_pan_joint"] == pytest.approx(0.4, rel=0.02)
    assert positions(small_arm)["left_lift_joint"] == pytest.approx(-0.5, abs=1e-3)


def test_its_sensor_measures_by_its_name(small_arm: tool0.Robot) -> None:
    small_arm.run(0.5)
    reading = small_arm.force_torque_of("left_tcp_fts_sensor").read()
    assert reading.frame == "left_tool0"
    assert np.linalg.norm(reading.force) == pytest.approx(0.7 * 9.81, rel=0.01)


@pytest.mark.parametrize(("arm", "gripper"), [("ur5", "2f85"), ("ur5e", "hande")])
def test_robots_of_the_catalogue_follow_positions(
    bring_up: BringUp, tmp_path: Path, arm: str, gripper: str
) -> None:
    driven = "finger_joint" if gripper == "2f85" else "hande_left_finger_joint"
    file = tmp_path / "controllers.yaml"
    joints = ", ".join([*UR_JOINTS, driven])
    file.write_text(CONTROLLERS.format(joints=joints, turned="elbow_joint"))
    robot = bring_up(
        arm=arm,
        gripper=gripper,
        ros2_control=True,
        controllers_file=file,
        controllers=["moving"],
    )
    robot.run(1.0)
    assert positions(robot)["shoulder_lift_joint"] == pytest.approx(-1.57, abs=1e-4)
    target = {"shoulder_lift_joint": -1.2, "elbow_joint": 0.8, driven: 0.02}
    for goal in robot.move_joints(target):
        assert goal.wait(10.0).error_code == 0
    robot.run(0.5)
    reached = positions(robot)
    assert {name: reached[name] for name in target} == pytest.approx(target, abs=1e-3)
