"""The arm sent to poses, in every physics: where it arrives, and how straight."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from conformance_types import BringUp
from ur5_rig import ARM_JOINTS, HOME

import tool0
from tool0.api.arm import Arm
from tool0.api.controller import GoalHandle
from tool0.description.transform import Pose, Transform, to_transform

CELL = Path(__file__).parents[2] / "examples" / "cell"
DOWN = (np.pi, 0.0, 0.0)
ARRIVED = 0.001
"""[m]; the default gains and position drives are within 0.02 mm after half a second."""
STRAIGHT = 0.002
"""[m]; 0.4 mm with the default gains, 0.02 mm with position drives."""
AT_HOME = dict(zip(ARM_JOINTS, HOME, strict=True))


def distance(a: Transform, b: Transform) -> float:
    return float(np.linalg.norm(np.subtract(a.position, b.position)))


def worst_aside(robot: tool0.Robot, arm: Arm, goal: GoalHandle, end: Pose) -> float:
    """Wait for the goal; return how far the tool was from its line at most [m]."""
    start = np.array(arm.pose().position)
    way = np.array(end.xyz) - start
    way /= np.linalg.norm(way)
    worst = 0.0
    while goal.result is None:
        robot.run(0.02)
        off = np.array(arm.pose().position) - start
        worst = max(worst, float(np.linalg.norm(off - way * (off @ way))))
    assert goal.result.status is tool0.GoalStatus.SUCCEEDED
    return worst


def test_the_default_arm_goes_to_a_pose_and_straight_down(
    bring_up: BringUp,
) -> None:
    robot = bring_up(initial_pose=AT_HOME)
    arm = robot.arm
    above = Pose(xyz=(0.45, 0.2, 0.35), rpy=DOWN)
    goal = arm.move_to(above)
    assert goal.wait(timeout=10.0).status is tool0.GoalStatus.SUCCEEDED
    robot.run(1.0)
    assert distance(arm.pose(), to_transform(above)) < ARRIVED
    below = Pose(xyz=(0.45, 0.2, 0.15), rpy=DOWN)
    assert worst_aside(robot, arm, arm.move_linear(below), below) < STRAIGHT
    robot.run(1.0)
    assert distance(arm.pose(), to_transform(below)) < ARRIVED


def test_drives_that_hold_their_place_arrive_and_keep_to_the_line(
    bring_up: BringUp,
) -> None:
    robot = bring_up(
        robot=CELL / "two_arms.urdf.xacro",
        controllers_file=CELL / "two_arms.yaml",
        controllers="left_arm right_arm",
        initial_pose={
            side + joint: q
            for side in ("left_", "right_")
            for joint, q in AT_HOME.items()
        },
    )
    left, right = robot.arms["left"], robot.arms["right"]
    for arm, y in ((left, 0.45), (right, -0.45)):
        pose = Pose(xyz=(0.4, y, 0.3), rpy=DOWN)
        goal = arm.move_to(pose)
        assert goal.wait(timeout=10.0).status is tool0.GoalStatus.SUCCEEDED
        robot.run(0.5)
        assert distance(arm.pose(), to_transform(pose)) < ARRIVED
    end = Pose(xyz=(0.5, 0.7, 0.2), rpy=(np.pi, 0.3, 0.5))
    assert worst_aside(robot, left, left.move_linear(end), end) < STRAIGHT
    robot.run(0.5)
    assert distance(left.pose(), to_transform(end)) < ARRIVED
