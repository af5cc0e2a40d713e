"""Frames at any rate, from snapshots at another one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from raises_naming import raises_naming

from tool0.collect.resampling import Resampled
from tool0.errors import CollectError, ConfigError

PERIOD = 0.001
TICKS = np.arange(0, 801, 8)  # 125 Hz for 0.8 s


def resampled(ticks: np.ndarray, rate: float) -> Resampled:
    return Resampled(ticks.astype(np.int64), PERIOD, rate, "one.mcap")


@pytest.mark.parametrize("rate", [10.0, 20.0, 25.0, 30.0, 50.0, 60.0, 125.0])
def test_frames_have_the_rate_and_straight_lines_stay_straight(rate: float) -> None:
    frames = resampled(TICKS, rate)
    (times,) = frames.between((TICKS * PERIOD)[:, None]).T
    np.testing.assert_allclose(np.diff(times), 1.0 / rate, atol=1e-12)
    assert times[0] == 0.0
    assert 0.8 - 1.0 / rate < times[-1] <= 0.8 + 1e-12


def test_frames_at_snapshots_are_these_to_the_bit() -> None:
    values = np.random.default_rng(0).normal(size=(len(TICKS), 3))
    frames = resampled(TICKS, 25.0)
    np.testing.assert_array_equal(frames.between(values), values[::5])
    np.testing.assert_array_equal(frames.nearest, np.arange(0, len(TICKS), 5))


def test_an_image_is_that_of_the_nearest_snapshot() -> None:
    frames = resampled(TICKS, 30.0)
    times = np.arange(len(frames.nearest)) / 30.0
    away = np.abs(TICKS[frames.nearest] * PERIOD - times)
    assert away.max() <= 0.004 + 1e-12


def test_frames_begin_with_the_snapshots_at_a_regular_rate() -> None:
    ticks = np.concatenate([[13], np.arange(16, 500, 8)])
    frames = resampled(ticks, 25.0)
    assert ticks[frames.nearest[0]] == 16


def test_frames_end_at_the_first_gap() -> None:
    whole = resampled(TICKS, 50.0).nearest
    for n_missing, n_frames in ((1, len(whole)), (3, 21)):
        ticks = np.delete(TICKS, range(51, 51 + n_missing))  # after 0.4 s
        assert len(resampled(ticks, 50.0).nearest) == n_frames


def test_between_a_number_and_none_is_none() -> None:
    values = np.ones((len(TICKS), 1))
    values[10:20] = math.nan
    found = resampled(TICKS, 125.0).between(values)
    np.testing.assert_array_equal(np.isnan(found), np.isnan(values))
    between = resampled(TICKS, 30.0).between(values)[:, 0]
    times = np.arange(len(between)) / 30.0
    is_inside = (times > 0.072) & (times < 0.160)
    np.testing.assert_array_equal(np.isnan(between), is_inside)


def test_turns_do_not_depend_on_the_sign_of_a_quaternion() -> None:
    angle = TICKS * PERIOD
    turns = np.stack([np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)], 1)
    turns[30:60] *= -1.0  # the same orientations
    poses = np.hstack([np.zeros((len(TICKS), 3)), turns])
    found = resampled(TICKS, 30.0).poses_between(poses)
    np.testing.assert_allclose(np.linalg.norm(found[:, 3:], axis=1), 1.0)
    times = np.arange(len(found)) / 30.0
    np.testing.assert_allclose(
        2 * np.arctan2(found[:, 6], found[:, 3]), times, atol=1e-6
    )


@pytest.mark.parametrize("rate", [0.0, -1.0, math.nan, math.inf, 126.0])
def test_a_rate_out_of_range_is_refused(rate: float) -> None:
    with raises_naming(ConfigError, "rate"):
        resampled(TICKS, rate)


@pytest.mark.parametrize("ticks", [[], [0], [0, 8], [0, 8, 8]])
def test_what_is_too_short_is_refused(ticks: list[int]) -> None:
    with raises_naming(CollectError, "one.mcap", "too short"):
        resampled(np.array(ticks), 50.0)
