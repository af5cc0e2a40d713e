"""Laws of a straight path and its timing: rest at both ends, limits kept."""

import numpy as np
import pytest

from tool0.description.transform import Pose, pose_matrix
from tool0.kinematics.line import LinePath, PathSegment, PathTiming

EVEN = PathSegment(1.0, 0.5, 2.0, 20.0)
SLOW = [
    EVEN._replace(end=0.4),
    EVEN._replace(end=0.6, speed=0.1),
    EVEN._replace(end=1.0),
]
CREEPING = [
    EVEN._replace(end=(k + 1) / 30, speed=0.5 * (1.02 - np.sin(np.pi * k / 29)))
    for k in range(30)
]
PATHS = {"even": [EVEN], "slow": SLOW, "creeping": CREEPING}


def sampled(timing: PathTiming) -> tuple[np.ndarray, np.ndarray]:
    times = np.linspace(0.0, timing.duration, 5001)
    return times, timing.at(times)


@pytest.mark.parametrize("segments", PATHS.values(), ids=PATHS.keys())
def test_it_goes_from_rest_to_rest_within_the_limits(
    segments: list[PathSegment],
) -> None:
    timing = PathTiming(segments)
    times, motion = sampled(timing)
    s, sd, sdd = motion.T
    np.testing.assert_allclose(motion[0], [0.0, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(motion[-1], [1.0, 0.0, 0.0], atol=1e-6)
    assert (np.diff(s) >= -1e-12).all()
    ends = [segment.end for segment in segments]
    speeds = np.array([segment.speed for segment in segments])
    inside = np.clip(np.searchsorted(ends, s), 0, len(segments) - 1)
    assert (sd <= speeds[inside] * (1 + 1e-6) + 1e-6).all()
    assert np.abs(sdd).max() <= 2.0 * (1 + 1e-9)
    # Speed and acceleration are steady: their slopes are what is allowed.
    step = times[1]
    assert np.abs(np.diff(sdd)).max() <= 20.0 * step * (1 + 1e-6)
    np.testing.assert_allclose(np.gradient(s, step)[1:-1], sd[1:-1], atol=1e-4)


def test_only_the_slow_segment_is_slow() -> None:
    even, slow = PathTiming([EVEN]), PathTiming(SLOW)
    extra = slow.duration - even.duration
    assert 0.2 / 0.1 - 0.2 / 0.5 < extra < 0.2 / 0.1 - 0.2 / 0.5 + 1.0
    _, motion = sampled(slow)
    assert motion[motion[:, 0] < 0.35, 1].max() == pytest.approx(0.5, rel=1e-3)


def test_it_takes_no_longer_than_it_must() -> None:
    """Ramps of constant acceleration alone would take 1/0.5 + 0.5/2 s."""
    assert PathTiming([EVEN]).duration == pytest.approx(2.25 + 2.0 / 20.0, abs=1e-9)


def test_half_a_turn_is_a_line_too() -> None:
    end = pose_matrix(Pose(rpy=(0.0, 0.0, np.pi)))
    line = LinePath(np.eye(4), end, np.eye(4))
    assert line.angle == pytest.approx(np.pi)
    np.testing.assert_allclose(line.tool(np.array([1.0]))[0], end, atol=1e-9)
