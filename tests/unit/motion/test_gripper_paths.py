"""The way between two openings: the laws of a planned motion."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import pytest

import tool0
from tool0.control.spline import Motion, Segment
from tool0.description.loading import assemble
from tool0.motion.gripper import RAMP_TIME, opening_path
from tool0.simulation.paths import trajectory_points

(GEOMETRY,) = assemble("ur5", "2f85").model.grippers
RAMP = GEOMETRY.speed[1] * RAMP_TIME / 2.0  # [m]
WAYS = [(0.085, 0.0), (0.0, 0.085), (0.06, 0.05), (0.02, 0.0204), (0.01, 0.07)]
SPEEDS = [0.02, 0.07, 0.15]


def plan(start: float, end: float, speed: float) -> list[tool0.TrajectoryPoint]:
    return trajectory_points(opening_path(GEOMETRY, start, end, speed))


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
def test_a_plan_goes_straight_to_its_target_and_ends_at_rest(
    start: float, end: float, speed: float
) -> None:
    points = plan(start, end, speed)
    last = points[-1]
    assert GEOMETRY.opening(last.positions[0]) == pytest.approx(end, abs=1e-9)
    assert last.velocities == pytest.approx((0.0,), abs=1e-9)
    times = [0.0, *(point.time_from_start for point in points)]
    assert all(a < b for a, b in itertools.pairwise(times))
    sign = math.copysign(1.0, end - start)
    for (t0, before), (t1, after) in itertools.pairwise(openings(start, points)):
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


@pytest.mark.slow
def test_every_way_between_two_openings_can_be_planned() -> None:
    openings = [k * 0.0005 for k in range(1, 170)] + [0.0, 0.085]
    for start, end in itertools.product(openings[::7], openings):
        for target in (end, 0.0, 0.085):
            assert plan(start, target, 0.15)
