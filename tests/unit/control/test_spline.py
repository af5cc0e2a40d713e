import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tool0.control.sampler import TrajectorySampler
from tool0.control.spline import JointSpline, Knots, Motion, Sample, hold, stop
from tool0.errors import ControlError

values = st.floats(-3.0, 3.0)
orders = st.integers(1, 3)
knots = st.lists(st.tuples(st.floats(0.1, 2.0), values, values, values), min_size=1)


def path(rows: list, order: int) -> list[tuple[float, Motion]]:
    time, result = 0.0, []
    for duration, *motion in rows:
        time += duration
        result.append((time, Motion(*motion[:order])))
    return result


def spliced(old: JointSpline, now: float, start: float, new: list) -> JointSpline:
    return old.spliced(now, start, Knots.of(new), suspects=range(1, len(new)))


@given(
    old_rows=knots,
    new_rows=knots,
    old_order=orders,
    order=orders,
    now=st.floats(0.0, 3.0),
    wait=st.floats(0.0, 3.0),
)
def test_splicing_keeps_the_old_motion_until_the_start_and_does_not_jump(
    *,
    old_rows: list,
    new_rows: list,
    old_order: int,
    order: int,
    now: float,
    wait: float,
) -> None:
    old = spliced(hold(0.0, 0.0), 0.0, 0.0, path(old_rows, old_order))
    start = now + wait
    new = path(new_rows, order)
    spline = spliced(old, now, start, new)
    for k in range(20):
        time = now + wait * k / 20
        if time < start:
            assert spline.sample(time) == old.sample(time)
    for time in (start, *(start + after for after, _ in new)):
        before, after = spline.sample(time - 1e-9), spline.sample(time + 1e-9)
        assert after.position == pytest.approx(before.position, abs=1e-5)
    for after, motion in new:
        at = spline.sample(start + after)
        assert at.position == pytest.approx(motion.position, abs=1e-6)
    assert spline.target == pytest.approx(new[-1][1].position, abs=1e-6)


def test_a_bridge_takes_its_order_from_the_first_new_knot() -> None:
    old = spliced(hold(0.0, 0.0), 0.0, 0.0, [(2.0, Motion(2.0))])
    linear = spliced(old, 1.0, 1.0, [(1.0, Motion(0.0))])
    cubic = spliced(old, 1.0, 1.0, [(1.0, Motion(0.0, 0.0))])
    assert linear.sample(1.0).velocity == pytest.approx(-1.0)
    assert cubic.sample(1.0).velocity == pytest.approx(1.0)


def test_splicing_forgets_what_is_over() -> None:
    spline = hold(0.0, 0.0)
    for k in range(100):
        spline = spliced(spline, 0.1 * k, 0.1 * k, [(0.3, Motion(1.0))])
    assert sum(len(section.span) for section in spline.sections) == 2


@pytest.mark.parametrize("limit", [1.0, 9.0])
def test_a_stop_does_not_end_beyond_the_limits(limit: float) -> None:
    spline = stop(0.0, Sample(0.9, 2.0, 0.0), 1.0, lambda q: min(q, limit))
    assert spline.target == pytest.approx(min(0.9 + 0.625 * 2.0, limit))
    assert spline.sample(0.0).velocity == 2.0


@given(knots, orders)
def test_sampling_tick_by_tick_is_sampling_the_splines(rows: list, order: int) -> None:
    spline = spliced(hold(0.0, 1.0), 0.0, 0.0, path(rows, order))
    sampler = TrajectorySampler([spline, hold(0.0, 2.0)], 0.0)
    for k in range(101):
        time = 1.1 * spline.end * k / 100
        if time >= sampler.next_change:
            sampler.advance(time)
        positions, velocities = sampler.desired(time)
        sample = spline.sample(time)
        assert positions == pytest.approx([sample.position, 2.0], abs=1e-7)
        assert velocities == pytest.approx([sample.velocity, 0.0], abs=1e-6)
        assert sampler.pieces[0].is_at_end == (time >= spline.end)


def test_nothing_is_known_before_the_oldest_segment() -> None:
    sampler = TrajectorySampler([hold(1.0, 0.0)], 1.0)
    assert sampler.samples(math.inf) == [(0.0, 0.0, 0.0)]
    with pytest.raises(ControlError):
        sampler.samples(0.5)
