"""Laws of speed profiles: lengths, speeds and durations by the formulas."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tool0.motion.profile import braking, ramp, smoothed, trapezoid

LENGTHS = st.floats(1e-4, 10.0)
RATES = st.floats(1e-2, 20.0)


@given(LENGTHS, RATES, RATES)
def test_from_rest_to_rest_it_takes_as_long_as_the_formula_says(
    length: float, speed: float, acceleration: float
) -> None:
    profile = trapezoid(length, speed, acceleration)
    if speed**2 / acceleration < length:
        expected, peak = length / speed + speed / acceleration, speed
        assert profile.times[1] == pytest.approx(speed / acceleration, abs=1e-9)
    else:
        expected = 2.0 * math.sqrt(length / acceleration)
        peak = math.sqrt(length * acceleration)
    assert profile.duration == pytest.approx(expected, rel=1e-9)
    assert profile.peak == pytest.approx(peak, rel=1e-9)
    assert profile.distances[-1] == length
    assert profile.speeds[-1] == pytest.approx(0.0, abs=1e-9)


@given(LENGTHS, RATES, RATES, st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_any_profile_is_the_integral_of_its_speed(
    length: float, speed: float, acceleration: float, before: float, after: float
) -> None:
    reach = math.sqrt(2.0 * acceleration * length)
    before = before * min(speed, reach)
    after = min(speed, after * math.sqrt(before**2 + reach**2))
    before = min(before, math.sqrt(after**2 + reach**2))
    profile = trapezoid(length, speed, acceleration, before, after)
    x, v, a = profile.at(np.linspace(0.0, profile.duration, 4001)).T
    step = profile.duration / 4000
    assert v[0] == pytest.approx(before, abs=1e-9)
    assert v[-1] == pytest.approx(after, abs=1e-6 * (1 + reach))
    assert x[-1] == pytest.approx(length)
    assert (np.abs(a) <= acceleration * (1 + 1e-9)).all()
    assert (v <= speed * (1 + 1e-9)).all()
    assert np.trapezoid(v, dx=step) == pytest.approx(length, rel=1e-3)
    assert (np.diff(x) >= -1e-12).all()


@given(LENGTHS, RATES, RATES)
def test_times_at_is_the_inverse(
    length: float, speed: float, acceleration: float
) -> None:
    profile = trapezoid(length, speed, acceleration)
    x = np.linspace(0.0, length, 101)
    found = profile.at(profile.times_at(x))
    np.testing.assert_allclose(found[:, 0], x, atol=1e-9 * length)
    np.testing.assert_allclose(found[:, 1], profile.speed_at(x), atol=1e-6)


@pytest.mark.parametrize("speed", [0.0, 0.1, 0.2, 3.0])
def test_braking_ends_at_rest_and_no_harder_than_needed(speed: float) -> None:
    profile = braking(0.05, speed, 1.2)
    x, v, a = profile.at(np.array([profile.duration]))[0]
    assert (x, v) == pytest.approx((0.05, 0.0), abs=1e-9)
    assert -a == pytest.approx(max(1.2, speed**2 / 0.1))


def test_a_ramp_has_one_acceleration() -> None:
    profile = ramp(0.3, 0.1, 0.5)
    assert profile.duration == pytest.approx(1.0)
    np.testing.assert_allclose(profile.at(np.array([0.5]))[0], [0.1, 0.3, 0.4])


@given(LENGTHS, RATES, RATES, st.floats(0.01, 0.5))
def test_a_smoothed_profile_changes_its_acceleration_in_small_steps(
    length: float, speed: float, acceleration: float, time: float
) -> None:
    sudden = trapezoid(length, speed, acceleration)
    profile = smoothed(sudden, time)
    assert profile.duration == pytest.approx(sudden.duration + time, rel=1e-6)
    assert profile.distances[-1] == length
    assert profile.peak <= sudden.peak * (1.0 + 1e-9)
    middles = (profile.times[1:] + profile.times[:-1]) / 2.0
    accelerations = profile.at(middles)[:, 2]
    assert np.abs(accelerations).max() <= acceleration * (1.0 + 1e-9)
    steps = np.diff(np.concatenate([[0.0], accelerations, [0.0]]))
    # Two copies may change theirs at once: speeding up ends, or slowing down begins.
    assert np.abs(steps).max() <= 0.51 * acceleration
    speeds = profile.speed_at(profile.distances)
    np.testing.assert_allclose(speeds[:-1], profile.speeds[:-1], atol=1e-6 * speed)
