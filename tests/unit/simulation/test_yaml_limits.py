"""Limits in the controllers' YAML hold for what is planned, not only for drives."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from ur5_rig import POST

import tool0
from tool0.description.transform import Pose
from tool0.protocol.program import MoveLinearStep, Program, ToolPose

LIMIT = 0.2
LIMITS = f"""
joint_limits:
  wrist_3_joint: {{has_velocity_limits: true, max_velocity: {LIMIT}}}
"""
BELOW = Pose(xyz=(0.45, 0.15, 0.3), rpy=(math.pi, 0.0, 0.0))
TURNED = Pose(xyz=(0.45, -0.05, 0.3), rpy=(math.pi, 0.0, 1.0))
TURN = Program(
    name="turn",
    steps=(MoveLinearStep(pose=ToolPose(xyz=TURNED.xyz, rpy=TURNED.rpy), speed=1.0),),
)


@pytest.mark.slow
@pytest.mark.parametrize("way", ["move_linear", "move_to", "program"])
def test_no_setpoint_is_faster_than_the_yaml_allows(tmp_path: Path, way: str) -> None:
    limits = tmp_path / "limits.yaml"
    limits.write_text(LIMITS)
    with tool0.bringup(controllers_file=[POST, limits], realtime=False) as robot:
        found = robot.arm.inverse_kinematics(BELOW)[0].positions
        robot.reset(found)
        if way == "move_linear":
            robot.arm.move_linear(
                TURNED, speed=1.0, angular_speed=3.0, collision="ignore"
            )
        elif way == "move_to":
            robot.arm.move_to(TURNED, speed=1.0)
        else:
            robot.run_program(TURN)
        speeds = []
        for _ in range(100):
            robot.run(0.05)
            setpoint = robot.snapshot.setpoints()["wrist_3_joint"]
            speeds.append(abs(setpoint.velocity))
        assert 0.2 * LIMIT < max(speeds) <= 1.02 * LIMIT
