from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest
from raises_naming import raises_naming
from skew_rig import START, build_core, executor, follow, switch

from tool0.control.trajectory import TrajectoryGoal
from tool0.description.drive_limits import DriveLimits
from tool0.description.loading import assemble
from tool0.errors import (
    ConfigError,
    ControlError,
    LimitsError,
)
from tool0.protocol.goals import GoalStatus
from tool0.protocol.trajectories import TrajectoryPoint
from tool0.simulation.core import Core


def ticks(core: Core, n: int) -> None:
    for _ in range(n):
        core.tick()


def test_time_is_the_number_of_ticks_times_the_control_period() -> None:
    core = build_core(control_period=0.004)
    ticks(core, 250)
    assert core.time == 250 * 0.004
    assert core.state.time == pytest.approx(1.0)  # the engine made four steps a tick


@pytest.mark.parametrize(
    "period", [0.0015, 0.0, -0.001, 0.0004, math.nan, math.inf, -math.inf]
)
def test_the_control_period_must_be_a_whole_multiple_of_the_step(period: float) -> None:
    with pytest.raises(ConfigError):
        build_core(control_period=period)


def test_drift_leaves_out_what_was_commanded_but_not_what_was_refused() -> None:
    core = build_core()
    follow(core, [0.5, -0.4], 0.3)
    ticks(core, 500)
    assert core.state.position[0] == pytest.approx(0.5, abs=1e-3)
    assert core.drift() < 1e-3  # the slide's
    core = build_core(started=("group",))
    with pytest.raises(ControlError):
        executor(core).command_joints("group", (math.nan, 0.0))
    switch(core, stop=("group",))
    core.engine.reset([0.4, -0.2, 0.05, 0.3])  # somebody pushed it
    core.state = core.engine.read()
    assert core.drift() == pytest.approx(0.1)
    assert core.drift(at_least=0.09) == core.drift()
    assert core.drift(at_least=0.11) == 0.11


HAND = replace(assemble().model.grippers[0], joint="lift")
GOAL = TrajectoryGoal(points=[TrajectoryPoint([0.0, 0.0], time_from_start=0.5)])
LIFTING: dict[str, Callable[[Core], object]] = {
    "a trajectory": lambda core: follow(core, [0.0, 0.0], 0.5),
    "a trajectory without a goal": lambda core: executor(core).command_trajectory(
        "arm", GOAL
    ),
    "a motion": lambda core: executor(core).move_joints({"lift": 0.1}, 0.5, None),
    "a motion with a duration": lambda core: executor(core).move_joints_within(
        {"lift": 0.1}, 0.5, None
    ),
    "steering": lambda core: executor(core).steer("arm", {"lift": 0.1}, 0.5),
    "another controller": lambda core: switch(core, ("group",), ("arm",)),
    "nobody": lambda core: switch(core, stop=("arm",)),
    "a reset": lambda core: core.reset({}, keep_time=False),
    "the emergency stop": lambda core: core.set_stopped(True),
}


def bound(core: Core, effort: float) -> DriveLimits:
    """Send a goal that bounds the drive of ``lift``, and return how."""
    bounds = DriveLimits(gripper=HAND, effort=effort)
    executor(core).follow("arm", GOAL, {"lift": bounds})
    return bounds


def test_a_goal_bounds_the_drive() -> None:
    core = build_core()
    goal = follow(core, [0.0, 0.0], 0.5)
    ticks(core, 1500)
    assert goal.status is GoalStatus.SUCCEEDED
    core.reset({}, keep_time=False)
    bound(core, 1e-6)  # beside what carries the weight
    ticks(core, 1500)
    assert abs(core.state.position[0]) > 0.05


@pytest.mark.parametrize("command", LIFTING.values(), ids=LIFTING)
def test_whatever_else_moves_the_joint_lifts_the_bounds(
    command: Callable[[Core], object],
) -> None:
    core = build_core()
    bounds = bound(core, 1.0)
    ticks(core, 10)
    assert core.hardware.drive_limits == {"lift": bounds}
    command(core)
    assert core.hardware.drive_limits == {}


def test_other_joints_and_refused_goals_leave_the_bounds_alone() -> None:
    core = build_core()
    bounds = bound(core, 1.0)
    executor(core).move_joints({"bend": 0.1}, 0.5, None)
    with pytest.raises(ControlError):
        follow(core, [math.nan, 0.0], 0.5)
    assert core.hardware.drive_limits == {"lift": bounds}


def test_a_command_for_another_kind_of_controller_says_which_it_needs() -> None:
    core = build_core(started=("arm", "slider"))
    with raises_naming(ControlError, "'arm'"):
        executor(core).command_joints("arm", (0.0, 0.0))
    with pytest.raises(ControlError):
        executor(core).command_gripper("slider", 0.0)
    executor(core).command_joints("slider", (0.1,))
    ticks(core, 1000)
    assert core.state.position[2] == pytest.approx(0.1, abs=1e-3)


def test_a_reset_begins_anew_and_preempts() -> None:
    core = build_core()
    goal = follow(core, [1.5, 1.5], 2.0)
    ticks(core, 500)
    core.reset({}, keep_time=False)
    assert goal.status is GoalStatus.PREEMPTED
    assert (core.time, core.ticks, core.state.position) == (0.0, 0, START)
    assert core.manager.status("arm").state == "running"
    ticks(core, 1000)
    assert core.drift() < 1e-3


def test_a_reset_may_place_joints_for_this_once() -> None:
    core = build_core()
    core.reset({"bend": 1.0}, keep_time=False)
    assert core.state.position == pytest.approx([0.3, 1.0, 0.05, -0.3])
    ticks(core, 100)
    assert core.drift() < 1e-3  # from where it was put
    core.reset({}, keep_time=False)
    assert core.state.position == START


def test_a_reset_to_an_impossible_pose_changes_nothing() -> None:
    core = build_core()
    goal = follow(core, [1.5, 1.5], 2.0)
    ticks(core, 100)
    before = core.state
    with pytest.raises(LimitsError):
        core.reset({"bend": 99.0}, keep_time=False)
    assert core.state is before
    assert goal.status is GoalStatus.ACTIVE


def test_the_emergency_stop_holds_refuses_and_lets_go() -> None:
    core = build_core()
    goal = follow(core, [1.5, 1.5], 1.0)
    ticks(core, 300)
    core.set_stopped(True)
    assert goal.status is GoalStatus.PREEMPTED
    ticks(core, 500)
    rest = core.state.position
    with pytest.raises(ControlError):
        follow(core, [0.0, 0.0], 1.0)
    ticks(core, 1000)
    assert core.state.position == pytest.approx(rest, abs=1e-3)
    core.set_stopped(False)
    ticks(core, 500)
    assert core.state.position == pytest.approx(rest, abs=1e-3)
    follow(core, [0.0, 0.0], 1.0)
    ticks(core, 1500)
    assert core.state.position[:2] == pytest.approx([0.0, 0.0], abs=1e-3)


def test_cancelling_a_goal_that_ended_does_nothing() -> None:
    core = build_core()
    goal = follow(core, [0.4, -0.2], 0.1)
    switch(core, stop=("arm",))
    assert goal.status is GoalStatus.PREEMPTED
    executor(core).cancel(goal)
