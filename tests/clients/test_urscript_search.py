"""A program that streams until it touches something, in real time."""

from __future__ import annotations

import pytest
from urscript_export import run_urscript

import tool0
from tool0 import MoveJointStep, Program, SetOutputStep, ToolPose, UntilStep
from tool0.scene import Pose

pytestmark = pytest.mark.slow


def test_the_urscript_searches_until_contact() -> None:
    # In real time: the script runs in a process of its own, which reacts in its time.
    start = ToolPose(xyz=(0.45, 0.1, 0.0), rpy=(3.14, 0.0, 0.0))
    program = Program(
        name="search",
        tool=ToolPose(xyz=(0.0, 0.0, 0.155)),
        steps=(
            MoveJointStep(pose=start, speed=2.0, acceleration=4.0),
            UntilStep(direction=(0.0, 0.0, -1.0), distance=0.05, speed=0.02),
            SetOutputStep(output=9),
        ),
    )
    with tool0.bringup(arm="ur5e", scene="table_and_bin") as robot:
        run_urscript(robot, program)
        height = robot.arm.pose(tool=Pose(xyz=program.tool.xyz)).position[2]
        assert -0.03 < height < -0.005  # the table's top is at -0.02 m
