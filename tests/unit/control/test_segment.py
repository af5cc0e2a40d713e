import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tool0.control.spline import (
    Motion,
    Sample,
    Segment,
    stop_ramp,
    wrap_offset,
)
from tool0.description.model import shortest_turn
from tool0.errors import GoalRejectedError

values = st.floats(-5.0, 5.0)
motions = st.builds(Motion, values, values, values)
durations = st.floats(0.05, 10.0)


def only(motion: Motion, order: int) -> Motion:
    return Motion(*motion[: order + 1])


@given(motions, motions, durations, st.integers(0, 2))
def test_meets_both_motions_up_to_its_order(
    first: Motion, last: Motion, duration: float, order: int
) -> None:
    segment = Segment(1.0, only(first, order), 1.0 + duration, only(last, order))
    scale = 1e-8 * (1.0 + duration**-2)
    for time, motion in ((1.0, first), (segment.end, last)):
        for got, wanted in zip(
            segment.sample(time)[: order + 1], motion[: order + 1], strict=True
        ):
            assert got == pytest.approx(wanted, abs=scale)


@given(motions, motions, durations, st.floats(0.01, 0.99))
def test_velocity_and_acceleration_are_derivatives(
    first: Motion, last: Motion, duration: float, part: float
) -> None:
    segment = Segment(0.0, first, duration, last)
    h = 1e-5 * duration
    time = duration * (h + part * (1.0 - 2.0 * h))
    before, now, after = (segment.sample(time + d) for d in (-h, 0.0, h))
    slope = (after.position - before.position) / (2 * h)
    bend = (after.velocity - before.velocity) / (2 * h)
    size = 1.0 + sum(map(abs, segment.coefficients)) * (1.0 + duration**3)
    assert now.velocity == pytest.approx(slope, abs=1e-6 * size)
    assert now.acceleration == pytest.approx(bend, abs=1e-6 * size)


def test_the_lowest_common_order_decides() -> None:
    full, bare = Motion(0.0, 1.0, 1.0), Motion(2.0)
    assert Segment(0.0, full, 1.0, bare).coefficients == (0.0, 2.0, 0, 0, 0, 0)
    assert Segment(0.0, full, 1.0, Motion(2.0, 0.0)).coefficients[4:] == (0.0, 0.0)
    no_velocity = Motion(1.0, None, 5.0)
    still = Segment(0.0, no_velocity, 1.0, no_velocity)
    assert still.coefficients == (1.0, 0, 0, 0, 0, 0)


def test_rests_outside_its_time() -> None:
    segment = Segment(1.0, Motion(0.0), 2.0, Motion(3.0))
    assert segment.sample(0.5) == Sample(0.0, 0.0, 0.0)
    assert segment.sample(2.5) == Sample(3.0, 0.0, 0.0)
    assert segment.sample(2.0).velocity == 3.0


def test_no_duration_keeps_the_start() -> None:
    segment = Segment(1.0, Motion(4.0, 1.0, 2.0), 1.0, Motion(5.0, 0.0, 0.0))
    assert segment.sample(1.0) == Sample(4.0, 1.0, 2.0)


@pytest.mark.parametrize("end", [0.5, math.nan])
def test_cannot_end_before_its_start(end: float) -> None:
    with pytest.raises(GoalRejectedError):
        Segment(1.0, Motion(0.0), end, Motion(0.0))


@given(values, values, durations)
def test_a_stop_ramp_ends_at_rest_five_eighths_of_the_way(
    position: float, velocity: float, duration: float
) -> None:
    first, last = stop_ramp(3.0, Sample(position, velocity, 9.0), duration)
    assert first == (position, velocity, 0.0)
    assert last.velocity == pytest.approx(0.0, abs=1e-8)
    assert last.position == pytest.approx(position + 0.625 * velocity * duration)


def test_overflowing_segments_are_unbounded() -> None:
    assert Segment(0.0, Motion(0.0), 1.0, Motion(1.0)).is_bounded(10.0)
    huge = Segment(0.0, Motion(0.0, 1e300), 1e-3, Motion(0.0, -1e300))
    assert not huge.is_bounded(1e9)


@given(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0))
def test_unwrapping_adds_whole_turns_and_ends_within_half_a_turn(
    previous: float, following: float
) -> None:
    offset = wrap_offset(previous, following)
    assert abs(offset / math.tau - round(offset / math.tau)) < 1e-9
    assert abs(following + offset - previous) <= math.pi + 1e-9


@given(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0))
def test_the_shortest_turn_arrives_and_is_short(start: float, end: float) -> None:
    turn = shortest_turn(start, end)
    assert -math.pi < turn <= math.pi
    assert math.cos(start + turn - end) == pytest.approx(1.0)


def test_half_a_turn_goes_the_way_of_the_numbers() -> None:
    assert wrap_offset(0.0, math.pi) == 0.0
    assert wrap_offset(0.0, -math.pi) == 0.0
    assert wrap_offset(0.0, math.pi - 1e-12) == pytest.approx(0.0)
