"""Accuracy of the gripper's speed and force, and delay of its object detection."""

from __future__ import annotations

import math

import numpy as np

import tool0
from tool0.description.grasp_frames import grasp_frame
from tool0.scene import Box, Pose, Scene, SceneObject

FORCES = (20.0, 60.0, 120.0, 235.0)  # [N]
SPEEDS = (0.02, 0.05, 0.10, 0.15)  # [m/s]
WIDTH = 0.045  # [m]
ROOM = 0.002  # [m]
SETTLE = 1.0  # [s]
ITEM = "block"


def force_error(engine: str) -> float:
    """Return the largest relative error of the force at a pad, from contact forces."""
    with _bring_up(engine) as robot:
        _put_between_pads(robot)
        errors = []
        for force in FORCES:
            robot.gripper.move(opening=0.0, force=force)
            robot.run(SETTLE)
            robot.contacts()  # Gazebo records contacts only after the first call
            robot.run(0.01)
            pressed = [
                float(np.linalg.norm(contact.force))
                for contact in robot.contacts()
                if ITEM in (contact.first, contact.second)
            ]
            errors += [abs(value / force - 1.0) for value in pressed]
        return max(errors)


def speed_error(engine: str) -> float:
    """Return the largest relative error of the pads' speed while closing.

    The speed is measured in the middle of the motion.
    """
    with _bring_up(engine) as robot:
        errors = []
        for speed in SPEEDS:
            robot.gripper.move(opening=0.085).wait(10.0)
            robot.gripper.move(opening=0.0, speed=speed)
            while robot.gripper.opening > 0.055:
                robot.run(robot.control_period)
            start, before = robot.time, robot.gripper.opening
            robot.run(0.024 / speed)
            way = before - robot.gripper.opening
            errors.append(abs(way / (robot.time - start) / speed - 1.0))
        return max(errors)


def detection_delay(engine: str) -> float:
    """Return the delay from the first contact to the report of a held object [s]."""
    with _bring_up(engine) as robot:
        robot.contacts()
        _put_between_pads(robot)
        robot.gripper.move(opening=0.0, force=60.0)
        touched = None
        for _ in range(round(SETTLE / robot.control_period)):
            robot.run(robot.control_period)
            if touched is None and robot.contacts():
                touched = robot.time
            if robot.gripper.state.motion == "holding_inside":
                break
        return math.inf if touched is None else robot.time - touched


def _bring_up(engine: str) -> tool0.Robot:
    """Bring up a robot, and a block that is not in its way."""
    away = Pose(xyz=(2.0, 0.0, 1.0))
    block = SceneObject(
        name=ITEM, geometry=Box(size=(0.04, WIDTH, 0.04)), pose=away, mass=0.1
    )
    return tool0.bringup(engine=engine, scene=Scene((block,)), realtime=False)


def _put_between_pads(robot: tool0.Robot) -> None:
    """Place the block between the pads in free fall.

    The opening is so small that the gripper catches the block.
    """
    robot.gripper.move(opening=WIDTH + ROOM).wait(10.0)
    robot.run(SETTLE)  # the arm comes to rest
    model, geometry = robot.description.model, robot.gripper.geometry
    frame = robot.pose("tool0") @ grasp_frame(model, geometry, WIDTH, "tool0")
    robot.scene.place(ITEM, frame.position, frame.quat_wxyz)
