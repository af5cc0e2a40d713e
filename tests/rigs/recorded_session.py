"""A short recording of a real robot: it moves, closes its gripper, and meets a wall."""

from pathlib import Path

import tool0
from tool0.protocol.recordings import StartRecording, StopRecording
from tool0.scene import Box

TURNED = [0.5, -1.3, 1.4, -1.7, -1.6, 0.0]
"""Where the arm is at the end [rad]."""
ADDED_AT = 1.5
"""Simulated time at which the box appears, at least [s]."""


def record_session(file: Path) -> None:
    """Record 3 s: a goal, another goal that is cancelled, and a box that is added."""
    with tool0.bringup(arm="ur5", gripper="2f85", realtime=False) as robot:
        robot.channel.call(StartRecording(file=str(file)))
        arm = robot.controller("eff_joint_traj_controller")
        point = tool0.TrajectoryPoint(positions=TURNED, time_from_start=1.0)
        arm.follow([point]).wait(timeout=5.0)
        robot.gripper.move(opening=0.02)
        robot.run(0.5)
        robot.scene.add("box", Box(size=(0.1, 0.1, 0.1)), xyz=(0.8, 0.0, 0.05), mass=1)
        back = tool0.TrajectoryPoint(positions=[0.0] * 6, time_from_start=20.0)
        goal = arm.follow([back])
        robot.run(0.5)
        goal.cancel()
        robot.run(0.5)
        robot.channel.call(StopRecording())
