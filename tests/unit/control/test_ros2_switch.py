"""Switches of ros2_control that ros_control answers differently."""

from __future__ import annotations

import pytest
from raises_naming import raises_naming
from ros2_arm import Point, arm, goal
from toy_robot import ToyRobot

from tool0.control.manager import Strictness
from tool0.errors import ControlError
from tool0.protocol.goals import GoalStatus


def switch(robot: ToyRobot, start=(), stop=(), strictness=Strictness.STRICT) -> None:
    robot.manager.switch(start, stop, strictness, robot.state)


@pytest.mark.parametrize("strictness", list(Strictness))
def test_one_switch_restarts_an_active_controller(strictness: Strictness) -> None:
    robot, controller = arm()
    running = controller.follow(goal(Point([1.0, 0.0, 0.0], time_from_start=1.0)), 0.0)
    robot.run(0.1)
    switch(robot, ["arm"], ["arm"], strictness)
    assert running.status is GoalStatus.ABORTED
    assert robot.manager.running("arm") is not controller
    assert robot.hardware.claimed == ["hip", "slide", "wheel"]
    before = list(robot.position)
    robot.run(0.1)
    assert robot.position == before


def test_an_inactive_controller_in_both_lists_is_refused_if_strict() -> None:
    robot, _ = arm()
    switch(robot, stop=["arm"])
    with raises_naming(ControlError, "'arm'", "not active"):
        switch(robot, ["arm"], ["arm"])
    switch(robot, ["arm"], ["arm"], Strictness.BEST_EFFORT)
    assert robot.manager.running("arm")


@pytest.mark.parametrize(
    ("start", "stop"),
    [(["nobody"], []), ([], ["nobody"]), (["nobody"], ["arm"]), (["arm"], ["nobody"])],
)
def test_a_list_of_unknown_controllers_is_an_error_in_any_case(
    start: list[str], stop: list[str]
) -> None:
    robot, controller = arm()
    with raises_naming(ControlError, "'nobody'"):
        switch(robot, start, stop, Strictness.BEST_EFFORT)
    assert robot.manager.running("arm") is controller


def test_best_effort_skips_unknown_controllers_beside_a_known_one() -> None:
    robot, _ = arm()
    switch(robot, stop=["nobody", "arm"], strictness=Strictness.BEST_EFFORT)
    (status,) = robot.manager.list()
    assert status.state == "inactive"
