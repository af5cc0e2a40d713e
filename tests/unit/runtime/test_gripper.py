"""The gripper by its opening: the laws of a planned motion."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import pytest

import tool0
from tool0.control.segment import Motion, Segment
from tool0.description.catalogue import assemble
from tool0.description.model import Box, Pose
from tool0.description.scene import Scene, SceneObject
from tool0.errors import ControlError, ModelError
from tool0.runtime.gripper import RAMP, Gripper

(GEOMETRY,) = assemble("ur5", "2f85").model.grippers
WAYS = [(0.085, 0.0), (0.0, 0.085), (0.06, 0.05), (0.02, 0.0204), (0.01, 0.07)]
SPEEDS = [0.02, 0.07, 0.15]


class StandingRobot:
    """All that planning asks of a robot: where the gripper is."""

    def __init__(self, opening: float) -> None:
        self.joint_state = self
        self.position = {GEOMETRY.joint: GEOMETRY.position(opening)}


def plan(start: float, end: float, speed: float) -> list[tool0.TrajectoryPoint]:
    gripper = Gripper(GEOMETRY, StandingRobot(start))  # type: ignore[arg-type]
    return gripper._plan(end, speed)


def segments(start: float, points: list[tool0.TrajectoryPoint]) -> list[Segment]:
    motion, time = Motion(GEOMETRY.position(start), 0.0, None), 0.0
    found = []
    for point in points:
        assert point.velocities is not None
        after = Motion(point.positions[0], point.velocities[0], None)
        found.append(Segment(time, motion, point.time_from_start, after))
        motion, time = after, point.time_from_start
    return found


def openings(
    start: float, points: list[tool0.TrajectoryPoint], n: int = 50
) -> Iterator[tuple[float, float]]:
    """Yield time [s] and opening [m] as a trajectory controller would play them."""
    for segment in segments(start, points):
        for k in range(n):
            time = segment.start + (segment.end - segment.start) * k / n
            yield time, GEOMETRY.opening(segment.sample(time).position)


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize(("start", "end"), WAYS)
def test_a_plan_ends_at_its_target_at_rest(
    start: float, end: float, speed: float
) -> None:
    last = plan(start, end, speed)[-1]
    assert GEOMETRY.opening(last.positions[0]) == pytest.approx(end, abs=1e-9)
    assert last.velocities == pytest.approx((0.0,), abs=1e-9)


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize(("start", "end"), WAYS)
def test_the_pads_never_turn_back_and_keep_the_speed(
    start: float, end: float, speed: float
) -> None:
    samples = list(openings(start, plan(start, end, speed)))
    sign = math.copysign(1.0, end - start)
    for (t0, before), (t1, after) in itertools.pairwise(samples):
        rate = sign * (after - before) / (t1 - t0)
        assert -1e-6 <= rate <= 1.10 * speed


@pytest.mark.parametrize("speed", SPEEDS)
def test_a_long_way_is_mostly_travelled_at_the_speed(speed: float) -> None:
    samples = list(openings(0.08, plan(0.08, 0.01, speed)))
    cruise = [(t, w) for t, w in samples if 0.015 < w < 0.075]
    (t0, w0), (t1, w1) = cruise[0], cruise[-1]
    assert (w0 - w1) / (t1 - t0) == pytest.approx(speed, rel=0.1)


@pytest.mark.parametrize("speed", SPEEDS)
def test_the_duration_is_the_way_plus_the_ramps(speed: float) -> None:
    duration = plan(0.08, 0.01, speed)[-1].time_from_start
    assert duration == pytest.approx((0.07 + 2 * RAMP) / speed, rel=1e-6)


@pytest.mark.parametrize("way", [0.0001, 0.001, 0.004, 0.009, 0.02])
def test_short_ways_speed_up_no_faster_than_long_ones(way: float) -> None:
    speed = 0.15
    samples = list(openings(0.04, plan(0.04, 0.04 - way, speed), n=20))
    most = speed**2 / (2 * RAMP)
    for (t0, a), (t1, b), (t2, c) in zip(
        samples, samples[1:], samples[2:], strict=False
    ):
        bend = ((c - b) / (t2 - t1) - (b - a) / (t1 - t0)) / ((t2 - t0) / 2)
        assert abs(bend) <= 1.3 * most


def test_to_stay_where_it_is_takes_no_time_to_speak_of() -> None:
    points = plan(0.04, 0.04, 0.15)
    assert points[-1].time_from_start < 0.01
    for point in points:
        assert point.velocities == pytest.approx((0.0,), abs=1e-6)


def test_every_way_between_two_openings_can_be_planned() -> None:
    openings = [k * 0.0005 for k in range(1, 170)] + [0.0, 0.085]
    for start, end in itertools.product(openings[::7], openings):
        for target in (end, 0.0, 0.085):
            assert plan(start, target, 0.15)


def test_times_always_increase() -> None:
    for (start, end), speed in itertools.product(WAYS, SPEEDS):
        times = [point.time_from_start for point in plan(start, end, speed)]
        assert all(a < b for a, b in itertools.pairwise([0.0, *times]))


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False) as robot:
        yield robot


@pytest.mark.parametrize("opening", [-0.001, 0.0851, math.nan, math.inf])
def test_an_opening_out_of_reach_is_refused(robot: tool0.Robot, opening: float) -> None:
    with pytest.raises(ModelError, match=r"opening .* is outside \[0, 0\.085\]"):
        robot.gripper.move(opening=opening)


@pytest.mark.parametrize("speed", [0.0, 0.019, 0.151, -0.1, math.nan])
def test_a_speed_that_the_gripper_lacks_is_refused(
    robot: tool0.Robot, speed: float
) -> None:
    with pytest.raises(ControlError, match=r"speed .* is outside \[0\.02, 0\.15\]"):
        robot.gripper.move(opening=0.04, speed=speed)


@pytest.mark.parametrize("effort", [0.0, -1.0, math.nan, math.inf])
def test_an_absurd_effort_is_refused_and_the_motion_goes_on(
    robot: tool0.Robot, effort: float
) -> None:
    goal = robot.gripper.move(opening=0.03)
    with pytest.raises(ControlError, match="effort must be above 0 and finite"):
        robot.gripper.move(opening=0.08, effort=effort)
    assert goal.wait(5.0).status is tool0.GoalStatus.SUCCEEDED
    assert robot.gripper.opening == pytest.approx(0.03, abs=1e-3)


def test_it_moves_at_the_speed_that_was_asked_for(robot: tool0.Robot) -> None:
    for speed in (0.02, 0.15):
        robot.gripper.move(opening=0.08).wait(5.0)
        robot.run(0.2)
        goal = robot.gripper.move(opening=0.01, speed=speed)
        robot.run((0.03 + RAMP) / speed)
        middle = robot.gripper.opening
        robot.run(0.01 / speed)
        rate = (middle - robot.gripper.opening) / (0.01 / speed)
        assert rate == pytest.approx(speed, rel=0.1)
        assert goal.wait(5.0).status is tool0.GoalStatus.SUCCEEDED


def test_a_refused_goal_leaves_the_effort_as_it_was(robot: tool0.Robot) -> None:
    robot.reset()
    robot.emergency_stop()
    with pytest.raises(ControlError, match="emergency stop"):
        robot.gripper.move(opening=0.0, effort=0.05)
    robot.emergency_stop(engaged=False)
    assert robot.gripper.move(opening=0.02).wait(5.0).error_code == 0
    robot.run(0.5)
    assert robot.gripper.opening == pytest.approx(0.02, abs=1e-3)


@pytest.mark.parametrize("force", [0.0, 19.0, 236.0, -50.0, math.nan])
def test_a_force_that_the_gripper_lacks_is_refused(
    robot: tool0.Robot, force: float
) -> None:
    with pytest.raises(ControlError, match=r"force .* is outside \[20\.0, 235\.0\] N"):
        robot.gripper.move(opening=0.04, force=force)


def test_a_force_and_an_effort_are_not_both_taken(robot: tool0.Robot) -> None:
    with pytest.raises(ControlError, match=r"force \(50 N\) or an effort \(2 N·m\)"):
        robot.gripper.move(opening=0.04, force=50, effort=2)


@pytest.mark.parametrize("width", [0.03, 0.06])
@pytest.mark.parametrize("force", [20.0, 60.0])
def test_the_drive_gives_the_force_that_was_asked_for(
    width: float, force: float
) -> None:
    block = SceneObject(
        name="block",
        geometry=Box(size=(width, width, 0.04)),
        pose=Pose(xyz=(0.5487, 0.1091, 0.003)),  # between the pads
    )
    with tool0.bringup(
        realtime=False, initial_pose="ready", scene=Scene((block,))
    ) as robot:
        robot.gripper.move(opening=0.0, force=force)
        robot.run(1.5)
        lever = GEOMETRY.lever(robot.joint_state.position[GEOMETRY.joint])
        given = robot.joint_state.effort[GEOMETRY.joint] / lever
        assert force <= given <= 1.11 * force, "as wide as it is, by its lever"
        robot.gripper.move(opening=0.0)
        robot.run(1.0)
        assert robot.joint_state.effort[GEOMETRY.joint] / lever > 1.2 * given


def test_without_a_controller_it_says_what_to_start(robot: tool0.Robot) -> None:
    robot.switch(stop=["gripper_controller"])
    with pytest.raises(
        ControlError, match="no running controller drives 'finger_joint'"
    ):
        robot.gripper.move(opening=0.04)
    robot.switch(start=["gripper_controller"])
    robot.gripper.move(opening=0.04)
