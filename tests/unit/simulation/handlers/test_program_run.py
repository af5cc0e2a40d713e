from __future__ import annotations

import math
import random
import re
from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np
import pytest
from taught_programs import at, search, taught_pick

import tool0
from tool0 import (
    CommentStep,
    GripperStep,
    LoopStep,
    MoveJointStep,
    MoveLinearStep,
    PlaceObjectStep,
    Program,
    ProgramHandle,
    SetOutputStep,
    ToolPose,
    UntilStep,
    WaitStep,
)
from tool0.protocol.arm_motion import ReturnArm, SpeedJoints, TakeArm

TIMEOUT = 60.0
"""[simulated s]"""


@pytest.fixture(scope="module")
def bringup() -> Iterator[tool0.Robot]:
    with tool0.bringup(arm="ur5e", scene="table_and_bin", realtime=False) as robot:
        yield robot


@pytest.fixture
def robot(bringup: tool0.Robot) -> tool0.Robot:
    bringup.reset()
    bringup.run(0.02)  # what a failed test left running ends
    return bringup


@pytest.mark.parametrize(
    ("step", "problem"),
    [
        (WaitStep(duration=math.nan), "'duration' must be finite"),
        (WaitStep(duration=-1.0), ">= 0.0"),
        (LoopStep(times=0), ">= 1"),
        (SetOutputStep(output=99), "<= 17"),
        (WaitStep(duration="1"), "Expected `float | null`, got `str`"),  # type: ignore[arg-type]
        (MoveJointStep(joints=[1.0]), "got `list`"),  # type: ignore[arg-type]
        (ToolPose(xyz=(0.4, 0.0, 0.0)), "Object missing required field `kind`"),
    ],
)
def test_a_program_of_objects_is_checked_like_one_of_a_file(
    robot: tool0.Robot, step: object, problem: str
) -> None:
    program = Program(name="odd", steps=(step,))  # type: ignore[arg-type]
    for use in (robot.run_program, robot.programs.check, robot.programs.save):
        with pytest.raises(tool0.Tool0Error, match=re.escape(problem)):
            use(program)


def test_loops_are_not_endlessly_deep(robot: tool0.Robot) -> None:
    step: CommentStep | LoopStep = CommentStep(text="deep")
    for _ in range(60):
        step = LoopStep(times=1, steps=(step,))
    deep = Program(name="deep", steps=(step,))
    for use in (robot.run_program, robot.programs.check, robot.programs.save):
        with pytest.raises(tool0.ControlError, match="more than 10 loops"):
            use(deep)


def test_a_program_that_stops_says_so(robot: tool0.Robot) -> None:
    on_the_way(robot).stop()
    with pytest.raises(tool0.ControlError, match="stops: let time pass"):
        robot.run_program(there_and_back())


@pytest.mark.slow
def test_in_real_time_a_program_waits_for_the_arm() -> None:
    """One that is released when hand guiding ends, or a program is stopped."""
    with tool0.bringup(arm="ur5e", gripper=None) as robot:
        robot.channel.call(TakeArm(by="hand guiding"))
        robot.channel.call(SpeedJoints(velocities=(0.5, 0, 0, 0, 0, 0)))
        robot.run(0.3)
        robot.channel.call(ReturnArm())
        handle = robot.run_program(Program(name="a", steps=(WaitStep(duration=9.0),)))
        handle.stop()
        again = robot.run_program(Program(name="b", steps=(WaitStep(duration=0.01),)))
        assert again.wait(TIMEOUT).state == "succeeded"


def there_and_back() -> Program:
    """Return a path of three moves, and a wait."""
    return Program(
        name="there and back",
        steps=(
            MoveJointStep(pose=at(0.4, 0.1, 0.4), speed=2.0, acceleration=4.0),
            CommentStep(text="two lines, blended"),
            MoveLinearStep(pose=at(0.4, 0.1, 0.25), blend=0.02),
            MoveLinearStep(pose=at(0.4, -0.1, 0.25)),
            WaitStep(duration=0.1),
        ),
    )


def wait_until(robot: tool0.Robot, is_so: Callable[[], bool]) -> None:
    assert robot.channel.wait_until(is_so, TIMEOUT)


def on_the_way(robot: tool0.Robot, program: Program | None = None) -> ProgramHandle:
    """Start a program, and return it in the midst of its third step."""
    handle = robot.run_program(program or there_and_back())
    wait_until(robot, lambda: handle.status.step == (3,))
    robot.run(0.2)
    return handle


def running(robot: tool0.Robot) -> set[str]:
    return {item.name for item in robot.controllers() if item.is_running}


def is_still(robot: tool0.Robot) -> bool:
    return max(map(abs, robot.joint_state.velocity.values())) < 0.01


@pytest.mark.slow
def test_a_taught_pick_succeeds_ten_of_ten_times(robot: tool0.Robot) -> None:
    seed = 20
    print("seed", seed)
    dice = random.Random(seed)
    program = taught_pick(robot)
    box = tool0.find_bin(robot.scene.objects, "bin")
    x, y, z = robot.scene.pose("cube").position
    for _ in range(10):
        dx, dy, yaw = (dice.uniform(-1.0, 1.0) for _ in range(3))
        half = 0.05 * yaw
        robot.scene.place(
            "cube",
            (x + 0.006 * dx, y + 0.006 * dy, z),
            (math.cos(half), 0.0, 0.0, math.sin(half)),
        )
        assert not box.holds(robot.scene.pose("cube"))
        end = robot.run_program(program).wait(TIMEOUT)
        assert (end.state, end.error) == ("succeeded", "")
        assert box.holds(robot.scene.pose("cube"))


def test_the_tool_follows_lines_and_blends(robot: tool0.Robot) -> None:
    handle = on_the_way(robot)
    points = []
    while handle.status.step in {(3,), (4,)}:
        robot.run(0.008)
        points.append(robot.arm.pose().position)
    away = [
        min(
            math.hypot(x - 0.4, y - 0.1) if z >= 0.25 else math.inf,
            math.hypot(x - 0.4, z - 0.25),
        )
        for x, y, z in points
    ]
    corner = min(math.dist(point, (0.4, 0.1, 0.25)) for point in points)
    assert max(away) < 0.01  # in the blend
    assert 0.002 < corner < 0.015
    assert handle.wait(TIMEOUT).state == "succeeded"
    assert robot.arm.pose().position == pytest.approx((0.4, -0.1, 0.25), abs=1e-3)


def test_a_paused_arm_stands_on_its_path_until_it_is_resumed(
    robot: tool0.Robot,
) -> None:
    handle = on_the_way(robot)
    handle.pause()
    robot.run(0.3)
    before, end = robot.arm.pose().position, handle.status
    assert (end.state, end.step) == ("paused", (3,))
    robot.run(0.3)
    assert robot.arm.pose().position == pytest.approx(before, abs=1e-4)
    assert 0.26 < before[2] < 0.39  # it did not go on to the target
    handle.resume()
    assert handle.wait(TIMEOUT).state == "succeeded"
    assert robot.arm.pose().position == pytest.approx((0.4, -0.1, 0.25), abs=1e-3)


def test_steps_are_executed_one_by_one(robot: tool0.Robot) -> None:
    handle = robot.run_program(there_and_back(), paused=True)
    ends = []
    while handle.status.state != "succeeded":
        wait_until(robot, lambda: handle.status.state != "running")
        ends.append((handle.status.step, robot.arm.pose().position))
        if handle.status.state == "paused":
            handle.step()
            robot.run(0.016)
    assert [step for step, _ in ends] == [(1,), (3,), (4,), (5,), (5,)]
    targets = [(0.4, 0.1, 0.4), (0.4, 0.1, 0.25), (0.4, -0.1, 0.25)]
    for (_, position), target in zip(ends[1:4], targets, strict=True):
        assert position == pytest.approx(target, abs=2e-3)


def test_a_step_from_within_a_blended_path_ends_at_its_target(
    robot: tool0.Robot,
) -> None:
    handle = on_the_way(robot)
    handle.pause()
    robot.run(0.3)
    handle.step()
    robot.run(0.016)
    wait_until(robot, lambda: handle.status.state == "paused")
    assert handle.status.step == (4,)
    assert robot.arm.pose().position == pytest.approx((0.4, 0.1, 0.25), abs=1e-3)
    handle.resume()
    assert handle.wait(TIMEOUT).state == "succeeded"


@pytest.mark.parametrize("paused", [False, True])
def test_a_stopped_program_leaves_the_arm_on_its_path(
    robot: tool0.Robot, paused: bool
) -> None:
    before = running(robot)
    handle = on_the_way(robot)
    if paused:
        handle.pause()
        robot.run(0.3)
    handle.stop()
    end = handle.wait(1.0)
    assert (end.state, end.error) == ("stopped", "it was stopped")
    assert running(robot) == before
    x, y, z = robot.arm.pose().position
    assert (x, y) == pytest.approx((0.4, 0.1), abs=2e-3)
    assert z > 0.26
    robot.run(0.5)
    assert is_still(robot)
    goal = robot.move_joints({"elbow_joint": 1.2})[0].wait()
    assert goal.status is tool0.GoalStatus.SUCCEEDED


def _reset(robot: tool0.Robot) -> None:
    robot.reset()


def _protective_stop(robot: tool0.Robot) -> None:
    robot.arm.control_box.stop_protectively("too close")


def _take(robot: tool0.Robot) -> None:
    robot.arm.motion.take("somebody")


def _stop_path(robot: tool0.Robot) -> None:
    robot.arm.motion.stop()


def _servo(robot: tool0.Robot) -> None:
    robot.arm.motion.servo_joints(list(robot.arm.joints.values()))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("what", "reason"),
    [
        (_reset, "the simulation was reset"),
        (_protective_stop, "protective stop: too close"),
        (lambda robot: robot.emergency_stop(), "the emergency stop was engaged"),
        (lambda robot: robot.arm.control_box.power_off(), "the arm was switched off"),
        (lambda robot: robot.arm.control_box.stop(), "something else stopped the arm"),
        (_take, "'somebody' took the arm"),
        (lambda robot: robot.arm.motion.release(), "something else stopped the arm"),
        (_stop_path, "something else stopped the arm on its path"),
        (_servo, "something else moves the arm"),
    ],
)
def test_something_else_ends_a_program_with_a_reason(
    robot: tool0.Robot, what: Callable[[tool0.Robot], None], reason: str
) -> None:
    handle = on_the_way(robot)
    what(robot)
    end = handle.wait(2.0)
    assert end.state == "stopped"
    assert reason in end.error
    robot.run(0.5)
    assert is_still(robot)
    box = robot.arm.control_box
    if box.state.taken_by:
        assert box.state.taken_by == "somebody"
        robot.arm.motion.release()
    if box.state.protective_stop:
        robot.run(5.0)
        box.unlock()
    robot.emergency_stop(False)
    box.release_brakes()
    box.play()
    robot.run(0.1)
    assert "eff_joint_traj_controller" in running(robot)
    assert robot.run_program(there_and_back()).wait(TIMEOUT).state == "succeeded"


@pytest.mark.slow
def test_a_held_cube_is_felt_at_the_table(robot: tool0.Robot) -> None:
    pick = taught_pick(robot)
    robot.arm.control_box.set_digital_output(5, False)
    steps = (
        *pick.steps[:7],
        UntilStep(direction=(0.0, 0.0, -1.0), distance=0.2, speed=0.05),
        SetOutputStep(output=5),
        GripperStep(opening="open"),
    )
    handle = robot.run_program(Program(name="place", steps=steps))
    wait_until(robot, lambda: robot.arm.control_box.state.digital_outputs[5])
    assert robot.scene.pose("cube").position[2] == pytest.approx(0.0025, abs=1.5e-3)
    assert handle.wait(TIMEOUT).state == "succeeded"


def test_a_search_without_contact_fails_unless_that_is_allowed(
    robot: tool0.Robot,
) -> None:
    up = {"direction": (0.0, 0.0, 1.0), "distance": 0.03}
    end = robot.run_program(search(**up)).wait(TIMEOUT)
    assert (end.state, end.step) == ("failed", (3,))
    assert end.error == "step 3: no contact on the whole way of 0.03 m"
    assert "eff_joint_traj_controller" in running(robot)
    end = robot.run_program(search(**up, must_touch=False)).wait(TIMEOUT)
    assert end.state == "succeeded"


def test_inputs_outputs_and_loops(robot: tool0.Robot) -> None:
    box = robot.arm.control_box
    box.set_digital_input(2, True)
    box.set_digital_input(3, False)
    program = Program(
        name="pins",
        steps=(
            LoopStep(
                while_input=2,
                steps=(SetOutputStep(output=1), SetOutputStep(output=1, level=False)),
            ),
            WaitStep(input=3, duration=5.0),
            LoopStep(times=3, steps=(WaitStep(duration=0.1),)),
            SetOutputStep(output=1),
        ),
    )
    handle = robot.run_program(program)
    robot.run(0.3)
    assert handle.status.step[0] == 1
    box.set_digital_input(2, False)
    robot.run(0.1)
    assert handle.status.step == (2,)
    box.set_digital_input(3, True)
    start = robot.time
    assert handle.wait(TIMEOUT).state == "succeeded"
    assert robot.time - start == pytest.approx(0.3, abs=0.1)
    assert box.state.digital_outputs[1]


def test_a_wait_stands_still_while_it_is_paused(robot: tool0.Robot) -> None:
    handle = robot.run_program(Program(name="wait", steps=(WaitStep(duration=0.2),)))
    robot.run(0.1)
    handle.pause()
    robot.run(1.0)
    assert handle.status.state == "paused"
    handle.resume()
    assert handle.wait(0.2).state == "succeeded"


def test_an_input_that_does_not_come_fails(robot: tool0.Robot) -> None:
    step = WaitStep(input=7, duration=0.1)
    end = robot.run_program(Program(name="wait", steps=(step,))).wait(TIMEOUT)
    assert end.error == "step 1: input 7 was not high within 0.1 s"


def test_a_gripper_that_must_hold_fails_when_it_is_empty(robot: tool0.Robot) -> None:
    step = GripperStep(opening="closed", must_hold=True)
    end = robot.run_program(Program(name="grip", steps=(step,))).wait(TIMEOUT)
    assert (end.state, end.step) == ("failed", (1,))
    assert "holds nothing" in end.error


def test_an_object_is_placed(robot: tool0.Robot) -> None:
    step = PlaceObjectStep(name="cube", xyz=(0.6, 0.2, 0.0025))
    end = robot.run_program(Program(name="place", steps=(step,))).wait(TIMEOUT)
    assert end.state == "succeeded"
    position = robot.scene.pose("cube").position
    assert position == pytest.approx((0.6, 0.2, 0.0025), abs=1e-3)


@pytest.mark.parametrize(
    ("step", "reason"),
    [
        (MoveJointStep(), "a move needs one target"),
        (MoveJointStep(named_pose="hmoe"), "did you mean 'home'?"),
        (MoveJointStep(joints={"elbow": 1.0}), "did you mean 'elbow_joint'?"),
        (MoveJointStep(joints={"elbow_joint": 1.0}), "lacks shoulder_pan_joint"),
        (MoveLinearStep(pose=at(2.0, 0.0, 0.2)), "out of reach"),
        (MoveLinearStep(pose=ToolPose(xyz=(0, 0, 0), relative_to="tool0")), "moves"),
        (GripperStep(opening=0.3), "outside [0, 0.085] m"),
        (GripperStep(opening=0.0, force=1e4), "force"),
        (PlaceObjectStep(name="cub", xyz=(0, 0, 0)), "did you mean 'cube'?"),
        (UntilStep(direction=(0, 0, 0), distance=0.1), "must not be zero"),
        (WaitStep(), "'duration' or an 'input'"),
        (LoopStep(), "needs a step"),
    ],
)
def test_an_impossible_step_is_reported_before_anything_moves(
    robot: tool0.Robot, step: tool0.Program, reason: str
) -> None:
    first = MoveJointStep(pose=at(0.4, 0.1, 0.4))
    loop = LoopStep(times=2, steps=(first, step))  # type: ignore[arg-type]
    program = Program(name="wrong", steps=(GripperStep(opening="open"), loop))
    before = robot.joint_state.position
    with pytest.raises(tool0.ProgramError, match=r"step 2\.2") as error:
        robot.run_program(program)
    assert reason in str(error.value)
    robot.run(0.1)
    assert robot.joint_state.position == pytest.approx(before, abs=5e-3)
    assert not robot.arm.control_box.state.taken_by


def test_one_program_of_an_arm_runs_at_a_time(robot: tool0.Robot) -> None:
    handle = on_the_way(robot)
    with pytest.raises(tool0.ControlError, match="still runs; stop it first"):
        robot.run_program(there_and_back())
    handle.stop()
    handle.wait(TIMEOUT)
    with pytest.raises(tool0.ControlError, match="no program runs on the arm 'arm'"):
        handle.pause()


def test_an_arm_that_is_taken_or_stopped_runs_no_program(robot: tool0.Robot) -> None:
    with (
        robot.arm.motion.taken("somebody"),
        pytest.raises(tool0.ControlError, match="'somebody' moves the arm 'arm'"),
    ):
        robot.run_program(there_and_back())
    robot.emergency_stop()
    with pytest.raises(tool0.ControlError, match="the emergency stop is engaged"):
        robot.run_program(there_and_back())
    robot.emergency_stop(False)


@pytest.mark.slow
def test_two_runs_are_identical_to_the_bit(robot: tool0.Robot) -> None:
    def trace() -> np.ndarray:
        robot.reset()
        with robot.record() as recording:
            assert robot.run_program(search()).wait(TIMEOUT).state == "succeeded"
        return recording.position

    first, second = trace(), trace()
    assert np.array_equal(first, second)


def test_the_setpoint_is_continuous_from_path_to_path(robot: tool0.Robot) -> None:
    handle = robot.run_program(there_and_back())
    rows = []
    while handle.status.state == "running":
        robot.run(0.008)
        setpoints = robot.snapshot.setpoints()
        rows.append([setpoints[name].position for name in robot.arm.joint_names])
    steps = [
        max(abs(a - b) for a, b in zip(one, two, strict=True))
        for one, two in pairwise(rows)
    ]
    assert max(steps) < 0.008 * 2.5  # the fastest joint turns at 2 rad/s
