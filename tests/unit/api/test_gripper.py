from __future__ import annotations

import math
import threading
from collections.abc import Iterator

import numpy as np
import pytest
from raises_naming import raises_naming
from ur5_rig import GRIPPER

import tool0
from tool0.errors import ControlError, GoalTimeoutError, ModelError, RequestError


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False) as robot:
        yield robot


@pytest.mark.parametrize("opening", [-0.001, 0.0851])
def test_an_opening_out_of_reach_is_refused(robot: tool0.Robot, opening: float) -> None:
    with raises_naming(ModelError, "0.085"):
        robot.gripper.move(opening=opening)


@pytest.mark.parametrize(
    ("setting", "value"), [("speed", 0.0), ("force", 236.0), ("effort", math.nan)]
)
def test_a_setting_out_of_range_is_refused_and_the_motion_goes_on(
    robot: tool0.Robot, setting: str, value: float
) -> None:
    robot.gripper.move(opening=0.07).wait(5.0)
    goal = robot.gripper.move(opening=0.03)
    with raises_naming(ControlError, setting):
        robot.gripper.move(opening=0.08, **{setting: value})
    assert goal.wait(5.0).status is tool0.GoalStatus.SUCCEEDED
    assert robot.gripper.opening == pytest.approx(0.03, abs=1e-3)


@pytest.mark.parametrize("what", ["opening", "speed", "force", "effort"])
@pytest.mark.parametrize("value", ["0.04", np.array([0.04]), math.nan, math.inf])
def test_what_is_no_finite_number_is_refused(
    robot: tool0.Robot, what: str, value: object
) -> None:
    with raises_naming(RequestError, what):
        robot.gripper.move(**{"opening": 0.04, what: value})  # type: ignore[arg-type]


def test_it_moves_from_the_moment_that_it_was_sent(robot: tool0.Robot) -> None:
    for opening, n_ticks in ((0.085, 0), (0.0, 1500), (np.float32(0.04), 0)):
        robot.gripper.move(opening=opening)  # type: ignore[arg-type]
        assert robot.gripper.state.motion == "moving"
        for _ in range(n_ticks):  # how often snapshots are published does not matter
            robot.run(0.001)
        state = robot.gripper.wait()
        assert (state.motion, state.gobj) == ("at_target", 3)
        assert state.opening == pytest.approx(opening, abs=1e-3)
        assert state == robot.gripper.state


@pytest.mark.parametrize("timeout", [0.0104, 0.05])
def test_to_wait_ends_whatever_the_control_period(timeout: float) -> None:
    with tool0.bringup(
        realtime=False, control=tool0.ControlConfig(control_period=0.02)
    ) as robot:
        robot.gripper.move(opening=0.0, speed=0.02)
        with pytest.raises(GoalTimeoutError):
            robot.gripper.wait(timeout)
        assert timeout <= robot.time < timeout + 0.02


def test_a_gripper_that_nobody_commands_is_idle(robot: tool0.Robot) -> None:
    robot.switch(stop=[GRIPPER])
    state = robot.gripper.wait()
    assert (state.motion, state.gobj) == ("idle", 0)
    with raises_naming(ControlError, "'finger_joint'"):
        robot.gripper.move(opening=0.04)
    robot.switch(start=[GRIPPER])
    robot.gripper.move(opening=0.04)


@pytest.mark.slow
def test_in_real_time_it_waits_for_the_wall_clock() -> None:
    with tool0.bringup(realtime=True) as robot:
        robot.set_speed(5.0)
        robot.gripper.move(opening=0.0)
        assert robot.gripper.wait(30.0).motion == "at_target"
        robot.gripper.move(opening=0.085, speed=0.02)
        robot.pause()
        with pytest.raises(GoalTimeoutError):
            robot.gripper.wait(0.05)
        ended = threading.Timer(0.1, robot.close)
        ended.start()
        with pytest.raises(ControlError):
            robot.gripper.wait(30.0)
        ended.join()
