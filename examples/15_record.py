"""Record a motion, measure how well a joint follows, and change its gains."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import tool0

ARM, ELBOW = "eff_joint_traj_controller", "elbow_joint"


def move(robot: tool0.Robot, target: float) -> tool0.Recording:
    """Move the elbow, and return the motion at 500 samples per second."""
    with robot.record(rate=500) as recording:
        robot.move_joints({ELBOW: target})[0].wait()
    return recording


def largest_error(recording: tool0.Recording) -> float:
    """Return the largest deviation of the elbow from its desired position [rad]."""
    error = recording.desired_position - recording.position
    return float(np.abs(error[:, recording.joint_names.index(ELBOW)]).max())


with tool0.bringup(realtime=False) as robot, TemporaryDirectory() as folder:
    stiff = move(robot, 1.0)
    print(f"{len(stiff)} samples, {stiff.missed} missed: {stiff.position.shape}")
    stiff.to_csv(Path(folder, "motion.csv"))

    elbow = robot.controller(ARM).set_gains(ELBOW, p=500.0, i=0.0)
    soft = move(robot, 1.5)
    print(f"largest error: {1000 * largest_error(stiff):.1f} mrad,", end=" ")
    print(f"with p = {elbow.p:g}: {1000 * largest_error(soft):.1f} mrad")
