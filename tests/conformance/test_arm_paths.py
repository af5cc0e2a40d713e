"""A taken arm follows its paths, in every physics."""

from __future__ import annotations

import numpy as np
from conformance_types import BringUp

RAISED = (0.5, -1.2, 1.2, -1.5, -1.5, 0.3)
REST = (0.0,) * 6
CLOSE = 0.004
"""Largest distance from the setpoint on the way [rad]; 1.2 mrad on MuJoCo."""


def test_a_taken_arm_follows_paths_and_is_released(bring_up: BringUp) -> None:
    robot = bring_up(gripper=None)
    motion = robot.arm.motion
    robot.run(0.5)

    def errors(duration: float) -> list[float]:
        found = []
        for _ in range(round(duration / 0.05)):
            robot.run(0.05)
            measured = [robot.snapshot.positions[j] for j in robot.arm.joint_names]
            wanted = motion.state.setpoint.positions
            found.append(float(np.abs(np.subtract(measured, wanted)).max()))
        return found

    motion.take()
    start = motion.state.setpoint.positions
    first = motion.execute_path([2.0], [RAISED], [REST])
    assert max(errors(1.0)) < CLOSE
    again = motion.execute_path([1.5], [start], [REST], after=first, at=1.2)
    assert max(errors(2.5)) < CLOSE
    assert (motion.state.path, motion.state.is_done) == (again, True)
    assert max(errors(0.5)) < 0.001
    motion.servo_joints([q + 0.1 for q in start])
    assert max(errors(1.5)) < CLOSE
    motion.release()
    robot.run(0.5)
    running = [status.name for status in robot.controllers() if status.is_running]
    assert "eff_joint_traj_controller" in running
