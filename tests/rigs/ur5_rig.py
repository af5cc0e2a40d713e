"""Names, poses and measures that tests of the whole share."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

import tool0
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose

CONTROLLERS = Path(__file__).parent.parent / "data" / "controllers"
TWO_ROBOTS = CONTROLLERS.parent / "description" / "two_robots.urdf.xacro"
POST = CONTROLLERS / "ur5_controllers.yaml"
POST_GRIPPER = CONTROLLERS / "robotiq_2f_85_gripper_controllers.yaml"

ARM = "eff_joint_traj_controller"
GRIPPER = "gripper_controller"
ARM_JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
HOME = (0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0)
AWAY = (0.5, -1.2, 1.3, -1.2, -1.2, 0.6)
BETWEEN_PADS = (0.5487, 0.1091, 0.003)
"""Where an object lies between the pads in the pose ``ready``, in the root [m].

The pads come down by 14 mm as they close; its height leaves them clear of the table."""
EDGE = 0.04
"""Of an object between the pads [m]."""
TABLE = SceneObject(
    name="table",
    geometry=Box(size=(0.4, 0.6, 0.04)),
    pose=Pose(xyz=(0.6, 0.0, BETWEEN_PADS[2] - EDGE / 2 - 0.02)),
)
"""Below it."""


def point(
    positions: Sequence[float],
    time: float,
    velocities: Sequence[float] | None = None,
) -> tool0.TrajectoryPoint:
    """Return a trajectory point."""
    return tool0.TrajectoryPoint(positions, velocities, time_from_start=time)


def positions(robot: tool0.Robot) -> np.ndarray:
    """Return the measured positions of all joints."""
    return np.array(list(robot.joint_state.position.values()))


def worst_departure(
    robot: tool0.Robot, duration: float, since: np.ndarray | None = None
) -> float:
    """Run, and return how far any joint went from where it was."""
    start = positions(robot) if since is None else since
    worst = 0.0
    for _ in range(round(duration / 0.05)):
        robot.run(0.05)
        worst = max(worst, float(np.abs(positions(robot) - start).max()))
    return worst
