import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tool0.control.segment import shortest_turn, wrap_offset
from tool0.control.playback import (
    Playback,
    Track,
    hold_track,
    sample_track,
    splice,
    stop_track,
)
from tool0.control.segment import Motion, Sample
from tool0.control.tolerances import NO_TOLERANCES
from tool0.errors import ControlError, GoalRejectedError

values = st.floats(-3.0, 3.0)
orders = st.integers(1, 3)
knots = st.lists(st.tuples(st.floats(0.1, 2.0), values, values, values), min_size=1)


def points(start: float, rows: list, order: int) -> list[tuple[float, Motion]]:
    time, result = start, []
    for duration, *motion in rows:
        time += duration
        result.append((time, Motion(*motion[:order])))
    return result


def merged(old: Track, now: float, start: float, new: list) -> Track:
    return splice(old, now, start, new, goal=None, tolerances=NO_TOLERANCES)


@given(
    old_rows=knots,
    new_rows=knots,
    old_order=orders,
    order=orders,
    now=st.floats(0.0, 3.0),
    wait=st.floats(-1.0, 3.0),
)
def test_merging_keeps_the_old_motion_until_the_start_and_does_not_jump(
    *,
    old_rows: list,
    new_rows: list,
    old_order: int,
    order: int,
    now: float,
    wait: float,
) -> None:
    old = merged(hold_track(0.0, 0.0), 0.0, 0.0, points(0.0, old_rows, old_order))
    start = now + wait
    new = points(max(now, start), new_rows, order)
    track = merged(old, now, start, new)
    leave = max(now, start)
    for k in range(21):
        time = now + (leave - now) * k / 20
        if time < leave:
            assert sample_track(track, time) == sample_track(old, time)
    assert sample_track(track, leave).position == pytest.approx(
        sample_track(old, leave).position, abs=1e-9
    )
    for time, motion in new:
        at = sample_track(track, time)
        assert at.position == pytest.approx(motion.position, abs=1e-6)
    h = 1e-9
    for time, _ in new:
        step = sample_track(track, time + h).position
        assert step == pytest.approx(sample_track(track, time - h).position, abs=1e-5)


@given(knots, orders)
def test_playing_tick_by_tick_is_sampling(rows: list, order: int) -> None:
    track = merged(hold_track(0.0, 1.0), 0.0, 0.0, points(0.0, rows, order))
    playback = Playback([track, hold_track(0.0, 2.0)], 0.0)
    end = track[-1].segment.end
    for k in range(101):
        time = 1.1 * end * k / 100
        if time >= playback.next_change:
            playback.advance(time)
        positions, velocities = playback.desired(time)
        wanted = sample_track(track, time)
        assert positions == pytest.approx([wanted.position, 2.0], abs=1e-7)
        assert velocities == pytest.approx([wanted.velocity, 0.0], abs=1e-6)
        assert playback.arrived[0] == (time >= end)


def test_a_bridge_takes_its_order_from_the_first_new_point() -> None:
    old = merged(hold_track(0.0, 0.0), 0.0, 0.0, [(2.0, Motion(2.0))])
    linear = merged(old, 1.0, 1.0, [(2.0, Motion(0.0))])
    cubic = merged(old, 1.0, 1.0, [(2.0, Motion(0.0, 0.0))])
    assert sample_track(linear, 1.0).velocity == pytest.approx(-1.0)
    assert sample_track(cubic, 1.0).velocity == pytest.approx(1.0)


def test_merging_forgets_what_is_over() -> None:
    track = hold_track(0.0, 0.0)
    for k in range(100):
        track = merged(track, 0.1 * k, 0.1 * k, [(0.1 * k + 0.3, Motion(1.0))])
    assert len(track) < 5


def test_rejects_motions_beyond_all_bounds() -> None:
    with pytest.raises(GoalRejectedError, match="no joint can move"):
        merged(hold_track(0.0, 0.0), 0.0, 0.0, [(1.0, Motion(0.0, 1e300))])


def test_a_stop_does_not_end_beyond_the_limits() -> None:
    track = stop_track(0.0, Sample(0.9, 2.0, 0.0), 1.0, lambda q: min(q, 1.0))
    assert sample_track(track, 2.0).position == pytest.approx(1.0)
    assert sample_track(track, 0.0).velocity == 2.0


def test_knows_nothing_before_its_oldest_segment() -> None:
    with pytest.raises(ControlError, match="oldest starts at 1"):
        Playback([hold_track(1.0, 0.0)], 1.0).motions(0.5)


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
