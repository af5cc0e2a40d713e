"""Two runs with the same commands at the same times are identical to the bit."""

from __future__ import annotations

import numpy as np
from conformance_types import BringUp
from ur5_rig import ARM, AWAY, HOME, point

import tool0

AGAIN = {"mujoco": 0.0, "gazebo": 1e-6}
"""Of any number that is seen: Gazebo's poses are off by the last bit after a reset."""


def run(robot: tool0.Robot) -> list[tuple[float, ...]]:
    """Do a bit of everything, and return every state that was seen."""
    seen: list[tuple[float, ...]] = []

    def go_on(duration: float) -> None:
        for _ in range(round(duration / 0.013)):
            robot.run(0.013)  # no multiple of any period inside
            state = robot.snapshot
            seen.append((state.time, *state.position, *state.velocity, *state.effort))

    arm = robot.controller(ARM)
    arm.follow([point(AWAY, 1.0)])
    go_on(0.3)
    robot.gripper.move(opening=0.02, speed=0.1)
    go_on(0.2)
    arm.follow([point(HOME, 1.0, [0.0] * 6)]).wait(5.0)
    robot.switch(stop=[ARM])
    go_on(0.2)
    robot.switch(start=["joint_group_eff_controller"])
    robot.controller("joint_group_eff_controller").command([0, -40, -12, 0, 0, 0])
    go_on(0.1)
    robot.emergency_stop()
    go_on(0.2)
    robot.emergency_stop(engaged=False)
    robot.switch(start=[ARM], stop=["joint_group_eff_controller"])
    robot.gripper.move(opening=0.085)
    robot.pause()
    robot.step(11)
    robot.resume()
    goal = arm.follow([point(AWAY, 1.0)])
    go_on(0.4)
    goal.cancel()
    go_on(0.7)
    return seen


def test_two_runs_with_the_same_commands_are_identical_to_the_bit(
    bring_up: BringUp,
) -> None:
    one, two = run(bring_up()), run(bring_up())
    assert len(one) > 100
    assert one == two


def test_a_run_after_a_reset_is_the_first_run_again(
    bring_up: BringUp, engine: str
) -> None:
    robot = bring_up()
    one = run(robot)
    robot.switch(stop=[ARM])
    robot.switch(start=[ARM])
    robot.reset()
    again = run(robot)
    assert len(again) == len(one)
    assert np.abs(np.subtract(again, one)).max() <= AGAIN[engine]


def test_how_time_is_asked_for_does_not_matter(bring_up: BringUp) -> None:
    whole, parts = bring_up(), bring_up()
    for robot in (whole, parts):
        robot.controller(ARM).follow([point(AWAY, 0.5)])
    whole.run(0.6)
    parts.pause()
    parts.step(100)
    parts.resume()
    for _ in range(100):
        parts.run(0.005)
    assert whole.snapshot.position == parts.snapshot.position


def test_the_thread_of_real_time_computes_the_same(bring_up: BringUp) -> None:
    fast = bring_up()
    fast.controller(ARM).follow([point(AWAY, 0.3)])
    fast.run(0.5)
    real = bring_up(realtime=True, paused=True)
    real.controller(ARM).follow([point(AWAY, 0.3)])
    real.step(500)
    assert real.snapshot.position == fast.snapshot.position
