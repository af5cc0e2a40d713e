"""What a survey passes is what looking at every point passes."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tool0.control.point_survey import BLOCK, survey
from tool0.control.segment import Motion, Segment
from tool0.control.trajectory import TrajectoryPoint

N_POINTS = 40
COUNTS = [1, 2, BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK, 2 * BLOCK + 1]

sizes = st.floats(-12.0, 12.0)
"""Powers of ten."""


def still(n_points: int, n_joints: int = 2) -> list[TrajectoryPoint]:
    rest = [0.0] * n_joints
    return [
        TrajectoryPoint(rest, rest, rest, time_from_start=float(k))
        for k in range(n_points)
    ]


@settings(deadline=None)
@given(
    seed=st.integers(0, 2**32),
    size=st.tuples(sizes, sizes, sizes, sizes),
    start=st.floats(0.0, 1e6),
    shift=st.floats(-1e3, 1e3),
)
def test_what_is_no_suspect_is_bounded(
    seed: int, size: tuple[float, ...], start: float, shift: float
) -> None:
    rng = np.random.default_rng(seed)
    spread = 10.0 ** rng.uniform(-4.0, 0.0, (N_POINTS, 4))
    scales = spread * np.power(10.0, size)
    times = np.cumsum(scales[:, 0] + 1e-12)
    numbers = rng.uniform(-1.0, 1.0, (3, N_POINTS, 2)) * scales.T[1:, :, None]
    orders = rng.integers(1, 4, N_POINTS)
    points = [
        TrajectoryPoint(
            *[*numbers[:order, k], None, None][:3], time_from_start=times[k]
        )
        for k, order in enumerate(orders)
    ]
    ends, suspects = survey(points).schedule(start, N_POINTS, abs(shift))
    assert ends == [start + point.time_from_start for point in points]
    for k in set(range(1, N_POINTS)) - set(suspects):
        for column in range(2):
            first, last = (motion(points[i], column, shift) for i in (k - 1, k))
            assert Segment(ends[k - 1], first, ends[k], last).is_bounded()


def motion(point: TrajectoryPoint, column: int, shift: float) -> Motion:
    rows = [point.velocities, point.accelerations]
    given = [None if row is None else row[column] for row in rows]
    return Motion(point.positions[column] + shift, *given)


def test_usual_motions_are_no_suspects() -> None:
    rng = np.random.default_rng(0)
    points = [
        TrajectoryPoint(q, 3.0 * q, 50.0 * q, time_from_start=0.001 * k)
        for k, q in enumerate(rng.uniform(-6.0, 6.0, (3 * BLOCK, 6)))
    ]
    _, suspects = survey(points).schedule(1000.0, len(points) - 5, 100.0)
    assert suspects == []


def test_only_the_points_ahead_are_suspects() -> None:
    points = still(3 * BLOCK)
    points[100] = TrajectoryPoint([0.0, 0.0], [0.0, 1e300], time_from_start=100.0)
    known = survey(points)
    assert known.schedule(0.0, len(points), 0.0)[1] == [100, 101]
    assert known.schedule(0.0, len(points) - 90, 0.0)[1] == [10, 11]
    assert known.schedule(0.0, len(points) - 100, 0.0)[1] == [1]
    assert known.schedule(0.0, len(points) - 101, 0.0)[1] == []


@pytest.mark.parametrize("n_points", COUNTS)
def test_sound_points_need_no_second_look(n_points: int) -> None:
    known = survey(still(n_points))
    assert (known.n_joints, known.n_timed, known.n_sound) == (2, n_points, n_points)
    assert list(known.beyond([(-1.0, 1.0)] * 2, n_points)) == []


@pytest.mark.parametrize("n_points", COUNTS)
@pytest.mark.parametrize("kind", ["positions", "velocities", "accelerations"])
@pytest.mark.parametrize("bad", [[math.nan, 0.0], [math.inf] * 2, [0.0], [0.0] * 3])
def test_unsound_numbers_are_looked_at(n_points: int, kind: str, bad: list) -> None:
    for victim in {n_points - 1, n_points // 2}:
        points = still(n_points)
        values = {"positions": [0.0, 0.0], kind: bad}
        points[victim] = TrajectoryPoint(**values, time_from_start=float(victim))
        known = survey(points)
        # A first point with other counts is for another controller.
        assert known.n_sound <= victim or known.n_joints != 2
        assert known.n_timed == n_points


def test_points_without_numbers_are_looked_at() -> None:
    assert survey(still(100, n_joints=0)).n_sound == 0


@pytest.mark.parametrize("time", [math.nan, math.inf, -math.inf, -1.0, 6.0])
def test_times_are_looked_at_from_the_first_that_does_not_increase(time: float) -> None:
    points = still(2 * BLOCK)
    points[7] = TrajectoryPoint([0.0] * 2, time_from_start=time)
    assert survey(points).n_timed == 7


@pytest.mark.parametrize("victim", [0, BLOCK - 1, BLOCK, 2 * BLOCK])
def test_positions_beyond_are_looked_at(victim: int) -> None:
    points = still(2 * BLOCK + 1)
    points[victim] = TrajectoryPoint([0.0, -1.5], time_from_start=float(victim))
    known = survey(points)
    assert victim in known.beyond([(0.0, 0.0), (-1.0, 1.0)], len(points))
    assert list(known.beyond([(0.0, 0.0), (-1.5, 1.0)], len(points))) == []
    ahead = len(points) - victim
    numbers = list(known.beyond([(0.0, 0.0), (-1.0, 1.0)], ahead))
    assert numbers[0] == 0
    assert numbers[-1] < min(ahead, BLOCK)
