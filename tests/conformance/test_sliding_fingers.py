"""Fingers that slide stay where they are while the arm turns them."""

from __future__ import annotations

import pytest
from conformance_types import BringUp

JOINT = "hande_left_finger_joint"


def test_the_drive_does_not_feel_the_turning_of_the_wrist(bring_up: BringUp) -> None:
    robot = bring_up(gripper="hande")
    robot.gripper.move(opening=0.02).wait(5.0)
    robot.run(0.5)
    start = robot.joint_state.position
    robot.move_joints({"wrist_3_joint": start["wrist_3_joint"] + 2.0}, speed=0.9)
    fastest = 0.0
    for _ in range(16):
        robot.run(0.05)
        state = robot.joint_state
        fastest = max(fastest, abs(state.velocity["wrist_3_joint"]))
        assert abs(state.effort[JOINT]) < 15.0
        assert state.position[JOINT] == pytest.approx(start[JOINT], abs=1e-4)
    assert fastest > 2.0
