"""After a stop every joint comes to rest and stays, whatever is carried or declared."""

from __future__ import annotations

import numpy as np
import pytest
from conformance_types import BringUp
from ur5_rig import ARM_JOINTS

import tool0
from tool0.scene import Sphere

RATED = {"ur5e": 5.0, "ur3": 3.0, "ur30": 35.0}
"""Largest payload of the arm [kg] (Universal Robots' data sheets)."""
OFFSET = (0.05, 0.0, 0.1)
"""Centre of gravity of the load in the flange's frame [m]."""
CASES = (
    ("emergency stop", 0.0),
    ("emergency stop", 10.0),
    ("protective stop", 5.0),
    ("power off", 10.0),
    ("power off", 0.0),
)
"""Stops, with a declared payload [kg]: all of them end in the same brakes."""


def load(robot: tool0.Robot, mass: float) -> None:
    """Fix a load to the flange that no drive knows of."""
    x, y, z = robot.pose("tool0").matrix[:3] @ [*OFFSET, 1.0]
    robot.scene.add("load", Sphere(radius=0.02), mass=mass, xyz=(x, y, z))
    robot.engine.world.attach("load", "tool0")


def stop(robot: tool0.Robot, kind: str) -> None:
    if kind == "emergency stop":
        robot.emergency_stop()
    elif kind == "protective stop":
        robot.arm.control_box.stop_protectively("test")
    else:
        robot.arm.control_box.power_off()


def values(robot: tool0.Robot, what: str) -> np.ndarray:
    measured = getattr(robot.joint_state, what)
    return np.array([measured[joint] for joint in ARM_JOINTS])


@pytest.mark.parametrize("arm", RATED)
def test_joints_at_rest_stay_under_a_load_that_nobody_declared(
    bring_up: BringUp, arm: str
) -> None:
    pose = dict(zip(ARM_JOINTS, (0.0, -0.4, 0.3, 0.0, 0.5, 0.3), strict=True))
    robot = bring_up(arm=arm, gripper=None, initial_pose=pose, ros2_control=True)
    load(robot, RATED[arm])
    robot.run(0.5)
    start = values(robot, "position")
    robot.emergency_stop()
    robot.run(2.0)
    assert np.abs(values(robot, "position") - start).max() < 0.02
    resting = values(robot, "position")
    robot.run(2.0)
    assert np.abs(values(robot, "position") - resting).max() < 1e-6  # 2 mrad in an hour


@pytest.mark.parametrize("is_ros2", [False, True], ids=["efforts", "positions"])
def test_moving_joints_rest_after_any_stop(bring_up: BringUp, is_ros2: bool) -> None:
    robot = bring_up(
        arm="ur5e", gripper=None, initial_pose="home", ros2_control=is_ros2
    )
    rng = np.random.default_rng(3)
    load(robot, RATED["ur5e"])
    for kind, declared in CASES:
        robot.reset()
        if not robot.scene.states:
            load(robot, RATED["ur5e"])
        robot.engine.world.attach("load", "tool0")
        robot.arm.control_box.set_payload(declared, OFFSET)
        start = values(robot, "position")
        away = rng.uniform(-1.0, 1.0, 6) * [1.0, 0.3, 0.5, 1.0, 1.0, 1.0]
        target = dict(zip(ARM_JOINTS, (start + away).tolist(), strict=True))
        robot.move_joints(target, speed=1.0, collision="ignore")
        robot.run(0.4)
        assert np.abs(values(robot, "velocity")).max() > 0.2
        stop(robot, kind)
        robot.run(1.0)
        assert np.abs(values(robot, "velocity")).max() <= 0.01, (kind, declared)
        resting = values(robot, "position")
        robot.run(0.5)
        assert np.abs(values(robot, "position") - resting).max() < 1e-5
        robot.emergency_stop(False)
        if kind == "protective stop":
            robot.run(5.0)
            robot.arm.control_box.unlock()
        robot.arm.control_box.release_brakes()
        robot.arm.control_box.play()


def test_a_brake_slips_under_more_than_its_torque(bring_up: BringUp) -> None:
    pose = dict(zip(ARM_JOINTS, (0.0, -0.6, 0.0, 0.0, 0.0, 0.0), strict=True))
    robot = bring_up(arm="ur5e", gripper=None, initial_pose=pose)
    robot.emergency_stop()
    start = values(robot, "position")
    robot.apply_wrench(
        "tool0", force=(0.0, 0.0, -100.0)
    )  # 28 N·m at wrist_1 need 200 N
    robot.run(0.5)
    assert np.abs(values(robot, "position") - start).max() < 1e-6
    robot.apply_wrench("tool0", force=(0.0, 0.0, -600.0))
    robot.run(0.2)
    assert np.abs(values(robot, "position") - start).max() > 0.01


@pytest.mark.parametrize(("carried", "declared"), [(0.0, 10.0), (5.0, 0.0), (5.0, 5.0)])
def test_servos_are_stable_with_any_declared_payload(
    bring_up: BringUp, carried: float, declared: float
) -> None:
    """In the end nothing oscillates, whatever offset was declared."""
    robot = bring_up(arm="ur5e", gripper=None, initial_pose="home", ros2_control=True)
    if carried:
        load(robot, carried)
    robot.arm.control_box.set_payload(declared, (0.1, 0.1, 0.1))
    robot.move_joints({"wrist_1_joint": -1.2, "wrist_3_joint": 0.5})
    robot.run(4.0)
    for _ in range(20):
        robot.run(0.025)
        assert np.abs(values(robot, "velocity")).max() < 0.02
