"""How still the gripper is when nobody moves it."""

from __future__ import annotations

import numpy as np

import tool0

OPENINGS = {"open": 0.085, "half": 0.040, "closed": 0.0}
SETTLE, DURATION, SAMPLE = 2.0, 10.0, 0.008  # [s]


def rms_velocity(opening: float) -> float:
    """Return the worst gripper joint's rms velocity over 10 s of rest [rad/s]."""
    with tool0.bringup(realtime=False) as robot:
        robot.gripper.move(opening=opening).wait(5.0)
        robot.run(SETTLE)
        names = robot.snapshot.joint_names
        gripper = names.index(robot.gripper.geometry.joint)
        samples = []
        for _ in range(round(DURATION / SAMPLE)):
            robot.run(SAMPLE)
            samples.append(robot.snapshot.velocity[gripper:])
    return float(np.sqrt(np.mean(np.square(samples), axis=0)).max())
