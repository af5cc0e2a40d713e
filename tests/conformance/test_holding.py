"""The arm never falls: what no controller claims stays where it is."""

from __future__ import annotations

import numpy as np
import pytest
from conformance_types import BringUp
from ur5_rig import (
    ARM,
    ARM_JOINTS,
    AWAY,
    GRIPPER,
    HOME,
    TWO_ROBOTS,
    point,
    positions,
    worst_departure,
)

import tool0
from tool0.errors import ControlError

ALLOWED = 1e-3  # [rad]
LONG = 10.0  # [s]
A_WHILE = 4.0  # [s], where another pose or robot is held for long
POSES = ["home", "ready", "up", "zero", "half", "closed"]


def random_pose(seed: int) -> dict[str, float]:
    """Return an arm above the ground that does not bump into itself."""
    rng = np.random.default_rng(seed)
    low = [-3.0, -2.2, 0.3, -2.2, -2.0, -3.0]
    high = [3.0, -0.8, 2.0, -0.5, -1.0, 3.0]
    pose = dict(zip(ARM_JOINTS, rng.uniform(low, high).tolist(), strict=True))
    return {**pose, "finger_joint": float(rng.uniform(0.0, 0.8))}


@pytest.mark.parametrize(
    ("engine", "pose"),
    [
        *(("mujoco", pose) for pose in (*POSES, *map(random_pose, range(3)))),
        *(("gazebo", pose) for pose in ("home", "zero", random_pose(3))),
    ],
    ids=str,
    indirect=["engine"],
)
def test_without_controllers_every_joint_stays_from_the_first_step_on(
    bring_up: BringUp,
    pose: str | dict[str, float],
    caplog: pytest.LogCaptureFixture,
) -> None:
    robot = bring_up(initial_pose=pose, controllers=[], stopped_controllers=[])
    start = positions(robot)
    assert "expect it to be pushed out" not in caplog.text
    for _ in range(50):  # the first steps, one by one
        robot.run(0.001)
        assert np.abs(positions(robot) - start).max() <= ALLOWED
    duration = LONG if pose in ("home", "zero") else A_WHILE
    assert worst_departure(robot, duration, start) <= ALLOWED
    assert robot.summary()["max_drift"] <= ALLOWED


def test_a_bare_arm_holds_too(bring_up: BringUp) -> None:
    robot = bring_up(gripper=None, controllers=[], stopped_controllers=[])
    assert worst_departure(robot, A_WHILE) <= ALLOWED


def test_two_arms_in_one_scene_hold_both(bring_up: BringUp) -> None:
    pose = dict(zip(ARM_JOINTS, HOME, strict=True))
    robot = bring_up(
        robot=TWO_ROBOTS,
        initial_pose={
            f"{s}_{j}": q for s in ("left", "right") for j, q in pose.items()
        },
        controllers=[],
        stopped_controllers=[],
    )
    assert len(robot.joint_state.position) == 24
    assert set(robot.grippers) == {"left", "right"}
    assert worst_departure(robot, A_WHILE) <= ALLOWED


def test_it_holds_at_other_steps_of_physics_and_control(bring_up: BringUp) -> None:
    for options in ({"dt": 0.0005}, {"control_period": 0.004}):
        robot = bring_up(controllers=[], stopped_controllers=[], **options)
        assert worst_departure(robot, 2.0) <= ALLOWED


def test_unclaimed_joints_hold_while_others_switch_on_and_off(
    bring_up: BringUp,
) -> None:
    robot = bring_up(initial_pose="zero", controllers=[])
    start = positions(robot)
    robot.load(GRIPPER)
    for _ in range(10):
        robot.switch(start=[GRIPPER])
        assert worst_departure(robot, 0.1, start) <= ALLOWED
        robot.switch(stop=[GRIPPER])
        assert worst_departure(robot, 0.1, start) <= ALLOWED


def test_an_arm_that_switches_on_and_off_sags_but_does_not_fall(
    bring_up: BringUp,
) -> None:
    robot = bring_up(initial_pose="zero", controllers=[])
    start = positions(robot)
    robot.load(ARM)
    for _ in range(5):
        robot.switch(
            start=[ARM]
        )  # effort begins at 0 without a gravity term, as in ROS
        robot.run(0.02)
        robot.switch(stop=[ARM])
        robot.run(0.2)
    assert np.abs(positions(robot) - start).max() < 0.05  # a free fall makes 1 rad
    assert worst_departure(robot, A_WHILE) <= ALLOWED


def test_it_holds_after_controllers_stop_in_mid_motion(bring_up: BringUp) -> None:
    robot = bring_up()
    robot.controller(ARM).follow([point(AWAY, 1.0)])
    robot.run(0.5)
    robot.switch(stop=[ARM, GRIPPER])
    robot.run(0.5)  # the brakes need a moment
    assert worst_departure(robot, LONG) <= ALLOWED


def test_started_but_never_commanded_effort_controllers_do_not_drop_the_arm(
    bring_up: BringUp,
) -> None:
    robot = bring_up()
    robot.switch(start=["joint_group_eff_controller"], stop=[ARM])
    robot.run(0.5)
    assert worst_departure(robot, 5.0) <= ALLOWED


def test_it_holds_through_pauses(bring_up: BringUp) -> None:
    robot = bring_up(controllers=[], stopped_controllers=[])
    start = positions(robot)
    for _ in range(5):
        robot.pause()
        robot.step(7)
        robot.resume()
        assert worst_departure(robot, 0.5, start) <= ALLOWED


def test_an_emergency_stop_in_mid_motion_brakes_and_then_holds(
    bring_up: BringUp,
) -> None:
    robot = bring_up()
    arm = robot.controller(ARM)
    goal = arm.follow([point(AWAY, 0.6)])
    robot.run(0.3)
    before = positions(robot)
    robot.emergency_stop()
    assert goal.status is tool0.GoalStatus.PREEMPTED
    for command in (
        lambda: arm.follow([point(AWAY, 1.0)]),
        lambda: arm.command_trajectory([point(AWAY, 1.0)]),
        lambda: robot.gripper.move(opening=0.0),
    ):
        with pytest.raises(ControlError):
            command()
    robot.run(0.5)
    assert np.abs(positions(robot) - before).max() < 0.1  # it did brake
    assert worst_departure(robot, 5.0) <= ALLOWED
    robot.emergency_stop(engaged=False)
    assert not robot.snapshot.is_stopped
    robot.run(1.0)
    result = arm.follow([point(AWAY, 1.0)]).wait(5.0)
    assert result.status is tool0.GoalStatus.SUCCEEDED
