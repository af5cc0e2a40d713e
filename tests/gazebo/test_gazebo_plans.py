"""Planned motions, which Gazebo executes without a contact."""

from __future__ import annotations

import pytest
from in_gazebo import BringUp

from tool0.api.controller import GoalStatus
from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose

WALL = SceneObject(
    name="wall", geometry=Box(size=(0.5, 0.03, 0.6)), pose=Pose(xyz=(0.6, 0.0, 0.3))
)
START = {
    "shoulder_pan_joint": -1.0,
    "shoulder_lift_joint": -0.9,
    "elbow_joint": 1.6,
    "wrist_1_joint": -2.2,
    "wrist_2_joint": -1.57,
    "wrist_3_joint": 0.0,
}


def test_plans_around_a_wall_touch_nothing(bring_up: BringUp) -> None:
    robot, _ = bring_up(scene=Scene((WALL,)), initial_pose=START)
    for seed, pan in enumerate((0.7, -1.0, 0.5)):
        plan = robot.arm.plan({"shoulder_pan_joint": pan}, speed=1.0, seed=seed)
        assert not plan.is_direct
        goal = robot.arm.execute(plan)
        while not goal.status.is_terminal:
            robot.run(0.1)
            assert not robot.contacts()
        assert goal.status is GoalStatus.SUCCEEDED
        found = robot.arm.joints["shoulder_pan_joint"]
        assert found == pytest.approx(pan, abs=0.02)
