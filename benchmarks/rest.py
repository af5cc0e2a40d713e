"""Measures the gripper's motion at rest, and the errors of its mimic joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import tool0

OPENINGS = {"open": 0.085, "half": 0.040, "closed": 0.0}
SETTLE, DURATION, SAMPLE = 2.0, 10.0, 0.008  # [s]
SPEED = 0.8
"""Speed of the finger while its mimic joints are measured [rad/s]."""


@dataclass(frozen=True)
class MimicError:
    """Largest deviation of any mimic joint from its relation [rad]."""

    moving: float
    at_rest: float


def rms_velocity(opening: float, engine: str) -> float:
    """Return the largest rms velocity of a gripper joint in 10 s of rest [rad/s]."""
    with tool0.bringup(engine=engine, realtime=False) as robot:
        robot.gripper.move(opening=opening).wait(5.0)
        robot.run(SETTLE)
        names = robot.snapshot.joint_names
        gripper = names.index(robot.gripper.geometry.joint)
        samples = []
        for _ in range(round(DURATION / SAMPLE)):
            robot.run(SAMPLE)
            samples.append(robot.snapshot.velocity[gripper:])
    return float(np.sqrt(np.mean(np.square(samples), axis=0)).max())


def mimic_error(engine: str) -> MimicError:
    """Measure the error while the finger moves at SPEED, and then at rest."""
    with tool0.bringup(engine=engine, realtime=False) as robot:
        finger = robot.gripper.geometry.joint
        controller = robot.controller("gripper_controller")
        controller.follow([tool0.TrajectoryPoint((0.05,), time_from_start=1.0)])
        robot.run(SETTLE)
        points = [
            tool0.TrajectoryPoint((0.15,), (SPEED,), time_from_start=0.25),
            tool0.TrajectoryPoint(
                (0.65,), (SPEED,), time_from_start=0.25 + 0.5 / SPEED
            ),
            tool0.TrajectoryPoint((0.75,), (0.0,), time_from_start=0.5 + 0.5 / SPEED),
        ]
        goal = controller.follow(points)
        moving = _worst(robot, finger, points[-1].time_from_start)
        if (result := goal.wait(1.0)).status is not tool0.GoalStatus.SUCCEEDED:
            raise RuntimeError(f"the finger did not get there: {result}")
        robot.run(SETTLE)
        return MimicError(moving=moving, at_rest=_worst(robot, finger, 1.0))


def _worst(robot: tool0.Robot, finger: str, duration: float) -> float:
    ratios = {
        joint.name: joint.mimic.multiplier
        for joint in robot.description.model.movable_joints
        if joint.mimic is not None
    }
    worst = 0.0
    for _ in range(round(duration / robot.engine.dt)):
        robot.run(robot.engine.dt)
        at = robot.joint_state.position
        error = max(abs(at[j] - ratio * at[finger]) for j, ratio in ratios.items())
        worst = max(worst, error)
    return worst
