"""Freedrive and force mode in the name of UR's controllers of ROS 2, in MuJoCo."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from raises_naming import raises_naming
from ur5_rig import ARM_JOINTS

import tool0
from tool0.errors import ClaimError, ControlError, GoalRejectedError, RequestError
from tool0.protocol.arm_motion import (
    EndForceMode,
    EndFreedrive,
    ReadArmMotion,
    StartForceMode,
    StartFreedrive,
)
from tool0.protocol.control_box_state import RobotMode

FORCE, FREEDRIVE = "force_mode_controller", "freedrive_mode_controller"
PASSTHROUGH, JTC = "passthrough_trajectory_controller", "joint_trajectory_controller"
SCALED = "scaled_joint_trajectory_controller"
BENT = dict(zip(ARM_JOINTS, (0.0, -1.2, 1.5, -1.87, -1.57, 0.0), strict=True))
ZERO = (0.0,) * 6
Z = (False, False, True, False, False, False)
PUSH = 20.0
"""Force downwards [N]."""
SPEED = 0.05
"""Largest speed along z [m/s]."""


@pytest.fixture(scope="module")
def shared() -> Iterator[tool0.Robot]:
    with tool0.bringup(
        arm="ur5e", ros2_control=True, realtime=False, initial_pose=BENT
    ) as robot:
        yield robot


@pytest.fixture
def robot(shared: tool0.Robot) -> Iterator[tool0.Robot]:
    yield shared
    others = active(shared) & {FORCE, FREEDRIVE, PASSTHROUGH, SCALED}
    shared.switch(start=sorted({JTC} - active(shared)), stop=sorted(others))
    shared.reset()


def active(robot: tool0.Robot) -> set[str]:
    return {item.name for item in robot.controllers() if item.is_running}


def push(robot: tool0.Robot, **changes: object) -> None:
    fields: dict[str, object] = {
        "frame": ZERO,
        "selection": Z,
        "wrench": (0.0, 0.0, -PUSH, 0.0, 0.0, 0.0),
        "limits": (0.1, 0.1, SPEED, 0.1, 0.1, 0.1),
        "controller": FORCE,
    }
    robot.channel.call(StartForceMode(**{**fields, **changes}))  # type: ignore[arg-type]


def end(robot: tool0.Robot) -> None:
    robot.channel.call(EndForceMode(controller=FORCE))


def place(robot: tool0.Robot) -> np.ndarray:
    return np.array(robot.arm.pose().position)


def speed(robot: tool0.Robot) -> float:
    return max(map(abs, robot.snapshot.velocity))


def turned(robot: tool0.Robot, by: float, duration: float) -> tool0.TrajectoryPoint:
    """Return a point to which only the first joint turns, from where it is wanted."""
    now = robot.snapshot.controller_setpoints[PASSTHROUGH].state().desired.positions
    there = np.add(now, [by, 0.0, 0.0, 0.0, 0.0, 0.0])
    return tool0.TrajectoryPoint(there.tolist(), [0.0] * 6, time_from_start=duration)


# ---- which controllers may be active together ----------------------------------------


@pytest.mark.parametrize("mode", [FORCE, FREEDRIVE])
def test_a_mode_excludes_controllers_of_its_joints(
    robot: tool0.Robot, mode: str
) -> None:
    with raises_naming(ClaimError, f"'{JTC}' and '{mode}' both claim"):
        robot.switch(start=[mode])
    assert mode not in active(robot)
    robot.switch(start=[mode], stop=[JTC])
    with raises_naming(ClaimError, f"'{JTC}' and '{mode}' both claim"):
        robot.switch(start=[JTC])
    robot.switch(start=[JTC], stop=[mode])


def test_force_mode_goes_with_the_passthrough_controller_alone(
    robot: tool0.Robot,
) -> None:
    robot.switch(start=[SCALED], stop=[JTC])
    with raises_naming(ClaimError, "goes with 'ur_controllers/PassthroughTraj"):
        robot.switch(start=[FORCE])
    robot.switch(start=[FORCE, PASSTHROUGH], stop=[SCALED])
    with raises_naming(ClaimError, f"'{PASSTHROUGH}' and '{FREEDRIVE}' both claim"):
        robot.switch(start=[FREEDRIVE], stop=[FORCE])
    assert {FORCE, PASSTHROUGH} <= active(robot)


def test_requests_need_the_controller_of_their_mode(robot: tool0.Robot) -> None:
    with raises_naming(GoalRejectedError, f"controller '{FORCE}' is inactive"):
        push(robot)
    robot.switch(start=[FREEDRIVE], stop=[JTC])
    with raises_naming(ControlError, "this needs a ur_controllers/ForceModeController"):
        push(robot, controller=FREEDRIVE)
    with raises_naming(ControlError, "no program moves the arm"):
        push(robot, controller=None)
    with raises_naming(ControlError, f"unknown controller '{FREEDRIVE}x'"):
        robot.channel.call(StartFreedrive(controller=f"{FREEDRIVE}x"))
    with raises_naming(RequestError, "gain_scaling"):
        push(robot, gain_scaling=-0.1)
    robot.emergency_stop()
    with raises_naming(ControlError, "emergency stop"):
        robot.channel.call(StartFreedrive(controller=FREEDRIVE))
    robot.emergency_stop(engaged=False)


# ---- force mode at rest --------------------------------------------------------------


def test_an_arm_at_rest_gives_way_along_the_selected_axis(robot: tool0.Robot) -> None:
    robot.switch(start=[FORCE], stop=[JTC])
    start = place(robot)
    push(robot)
    robot.run(1.0)
    assert robot.channel.call(ReadArmMotion()).force_mode
    moved = place(robot) - start
    assert -1.05 * SPEED < moved[2] < -0.6 * SPEED
    assert np.abs(moved[:2]).max() < 2e-4
    end(robot)
    assert not robot.channel.call(ReadArmMotion()).force_mode
    robot.run(0.3)
    held = place(robot)
    assert speed(robot) < 1e-4
    assert 0.0 < start[2] + moved[2] - held[2] < 0.005  # it ramps down
    robot.run(1.0)
    assert place(robot) == pytest.approx(held, abs=1e-6)


def test_another_task_replaces_the_first(robot: tool0.Robot) -> None:
    robot.switch(start=[FORCE], stop=[JTC])
    push(robot)
    robot.run(0.5)
    start = place(robot)
    push(robot, wrench=(0.0, 0.0, PUSH, 0.0, 0.0, 0.0))
    robot.run(0.5)
    assert place(robot)[2] > start[2] + 0.3 * SPEED


def test_the_least_gain_damps_most(robot: tool0.Robot) -> None:
    robot.switch(start=[FORCE], stop=[JTC])
    ways = []
    for gain in (1.0, 0.0):
        push(robot, gain_scaling=gain, limits=(1.0,) * 6)
        start = place(robot)
        robot.run(0.2)
        ways.append(start[2] - place(robot)[2])
        end(robot)
        robot.run(0.3)
    assert 0.0 < ways[1] < 0.2 * ways[0]


# ---- force mode with a trajectory ----------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("is_first", [True, False], ids=["before", "after"])
def test_the_arm_deviates_from_the_trajectory_along_the_selected_axis(
    robot: tool0.Robot, is_first: bool
) -> None:
    first, second = [FORCE], [PASSTHROUGH]
    if not is_first:
        first, second = second, first
    robot.switch(start=first, stop=[JTC])
    robot.switch(start=second)
    start, angle = place(robot), robot.joint_state.position["shoulder_pan_joint"]
    push(robot)
    goal = robot.controller(PASSTHROUGH).follow([turned(robot, 0.5, 2.0)])
    robot.run(2.1)
    assert goal.status is tool0.GoalStatus.SUCCEEDED
    assert robot.joint_state.position["shoulder_pan_joint"] == pytest.approx(
        angle + 0.5, abs=2e-3
    )
    there = place(robot)
    assert there[2] < start[2] - SPEED
    assert np.hypot(*there[:2]) == pytest.approx(np.hypot(*start[:2]), abs=1e-3)
    end(robot)
    robot.run(0.5)
    assert place(robot) == pytest.approx(there, abs=0.01)
    back = robot.controller(PASSTHROUGH).follow([turned(robot, -0.5, 1.0)])
    robot.run(1.2)
    assert back.status is tool0.GoalStatus.SUCCEEDED
    assert place(robot)[2] == pytest.approx(there[2], abs=0.01)


@pytest.mark.slow
def test_an_arm_that_deviates_neither_stalls_nor_stops(robot: tool0.Robot) -> None:
    robot.switch(start=[FORCE, PASSTHROUGH], stop=[JTC])
    robot.arm.control_box.set_safety_limits(enabled=True)
    before = np.array(list(robot.joint_state.position.values()))
    push(robot, wrench=(0.0, 0.0, PUSH, 0.0, 0.0, 0.0), limits=(0.5,) * 6)
    robot.run(0.8)
    push(robot, wrench=ZERO)
    robot.run(1.5)
    after = np.array(list(robot.joint_state.position.values()))
    assert np.abs(after - before).max() > 0.2
    assert speed(robot) < 0.01
    assert robot.snapshot.stalls == ()
    assert robot.arm.control_box.state.protective_stop == ""
    robot.arm.control_box.set_safety_limits(enabled=False)


@pytest.mark.slow
def test_a_trajectory_on_which_force_mode_ends_is_aborted(robot: tool0.Robot) -> None:
    robot.switch(start=[FORCE, PASSTHROUGH], stop=[JTC])
    push(robot)
    goal = robot.controller(PASSTHROUGH).follow([turned(robot, 0.5, 2.0)])
    robot.run(1.0)
    end(robot)
    result = goal.result
    assert result is not None
    assert "Force mode has ended" in result.error_string
    before = place(robot)
    robot.run(0.5)
    assert speed(robot) < 1e-3
    assert place(robot) == pytest.approx(before, abs=0.03)


@pytest.mark.slow
def test_it_lasts_while_its_controller_is_active(robot: tool0.Robot) -> None:
    robot.switch(start=[FORCE, PASSTHROUGH], stop=[JTC])
    push(robot)
    heights = [place(robot)[2]]

    def descends(change: Callable[[], object]) -> bool:
        change()
        robot.run(0.4)
        heights.append(place(robot)[2])
        return bool(heights[-1] < heights[-2] - 0.2 * SPEED)

    assert descends(lambda: None)
    assert descends(lambda: robot.switch(stop=[PASSTHROUGH]))
    assert descends(lambda: robot.switch(start=[PASSTHROUGH]))
    robot.switch(stop=[FORCE])
    robot.run(0.3)
    assert not descends(lambda: None)
    assert speed(robot) < 1e-3
    with raises_naming(GoalRejectedError, "is inactive"):
        end(robot)
    assert active(robot) >= {PASSTHROUGH}


def test_joints_may_be_in_any_order(tmp_path: Path) -> None:
    file = tmp_path / "controllers.yaml"
    joints = ", ".join(reversed(ARM_JOINTS))
    file.write_text(
        f"""{PASSTHROUGH}:
  ros__parameters:
    type: ur_controllers/PassthroughTrajectoryController
    joints: [{joints}]
    state_interfaces: [position, velocity]
{FORCE}:
  ros__parameters:
    type: ur_controllers/ForceModeController
"""
    )
    with tool0.bringup(
        arm="ur5e",
        ros2_control=True,
        realtime=False,
        initial_pose=BENT,
        controllers_file=file,
        controllers=(PASSTHROUGH, FORCE),
    ) as robot:
        start = place(robot)
        push(robot)
        robot.run(1.0)
        moved = place(robot) - start
        assert -1.05 * SPEED < moved[2] < -0.6 * SPEED
        assert np.abs(moved[:2]).max() < 2e-4


def test_an_unknown_prefix_names_those_of_the_arms(tmp_path: Path) -> None:
    file = tmp_path / "controllers.yaml"
    file.write_text(
        f"{FORCE}:\n  ros__parameters:\n    tf_prefix: left_\n"
        "    type: ur_controllers/ForceModeController\n"
    )
    with raises_naming(tool0.ConfigError, "no arm has the prefix 'left_'; valid: ''"):
        tool0.bringup(
            arm="ur5e", ros2_control=True, controllers_file=file, controllers=FORCE
        )


# ---- freedrive -----------------------------------------------------------------------


@pytest.mark.slow
def test_freedrive_follows_a_push_and_the_arm_stays(robot: tool0.Robot) -> None:
    box = robot.arm.control_box
    robot.switch(start=[FREEDRIVE], stop=[JTC])
    start = place(robot)
    robot.apply_wrench("tool0", force=(0.0, PUSH, 0.0), duration=0.5)
    robot.run(0.6)
    assert place(robot) == pytest.approx(start, abs=1e-3)  # it is not on
    for _ in range(2):  # a second request changes nothing
        robot.channel.call(StartFreedrive(controller=FREEDRIVE))
    assert box.state.robot_mode is RobotMode.BACKDRIVE
    robot.run(0.5)
    assert place(robot) == pytest.approx(start, abs=1e-3)
    robot.apply_wrench("tool0", force=(0.0, PUSH, 0.0), duration=0.5)
    robot.run(1.5)
    there = place(robot)
    assert there[1] > start[1] + 0.03
    robot.channel.call(EndFreedrive(controller=FREEDRIVE))
    assert box.state.robot_mode is RobotMode.RUNNING
    robot.run(0.3)
    robot.apply_wrench("tool0", force=(0.0, PUSH, 0.0), duration=0.5)
    robot.run(0.6)
    assert place(robot) == pytest.approx(there, abs=1e-3)


@pytest.mark.parametrize("way", ["deactivated", "stopped", "emergency", "reset"])
def test_freedrive_ends_with_its_controller(robot: tool0.Robot, way: str) -> None:
    box = robot.arm.control_box
    robot.switch(start=[FREEDRIVE], stop=[JTC])
    robot.channel.call(StartFreedrive(controller=FREEDRIVE))
    robot.apply_wrench("tool0", force=(0.0, PUSH, 0.0), duration=0.5)
    robot.run(0.4)
    assert speed(robot) > 0.02
    if way == "deactivated":
        robot.switch(start=[JTC], stop=[FREEDRIVE])
    elif way == "stopped":
        box.stop_protectively("a test")
        assert FREEDRIVE not in active(robot)
    elif way == "emergency":
        robot.emergency_stop()
        robot.emergency_stop(engaged=False)
    else:
        robot.reset()
    assert box.state.robot_mode is RobotMode.RUNNING
    robot.run(0.5)
    held = place(robot)
    robot.apply_wrench("tool0", force=(0.0, PUSH, 0.0), duration=0.3)
    robot.run(0.4)
    assert place(robot) == pytest.approx(held, abs=1e-3)
    if way == "stopped":
        robot.run(5.0)
        box.unlock()
        box.play()


def test_a_program_that_takes_the_arm_ends_freedrive(robot: tool0.Robot) -> None:
    robot.switch(start=[FREEDRIVE], stop=[JTC])
    robot.channel.call(StartFreedrive(controller=FREEDRIVE))
    robot.arm.motion.take()
    assert FREEDRIVE not in active(robot)
    assert robot.arm.control_box.state.robot_mode is RobotMode.RUNNING
    with raises_naming(ControlError, "moves the arm 'arm'; stop that first"):
        robot.switch(start=[FREEDRIVE])
    robot.arm.motion.release()
    robot.run(0.5)
    assert FREEDRIVE in active(robot)
