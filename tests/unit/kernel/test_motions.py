"""Motions of many joints at once are those of JointTrajectoryControllers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tool0.control.spline import JointSpline, Knots, Motion, hold
from tool0.kernel.motions import Motions

N = 5
START = 0.25


@pytest.mark.parametrize("has_velocities", [True, False])
@pytest.mark.parametrize("n_points", [1, 3])
def test_motions_are_those_of_splines(has_velocities: bool, n_points: int) -> None:
    rng = np.random.default_rng(n_points)
    home = rng.uniform(-1.0, 1.0, (N, 2))
    motions = Motions(home, [False, False])
    splines = [hold(0.0, q) for q in home[:, 1].tolist()]
    rows = np.arange(N)
    for now in (START, START + 0.11):  # the second one replaces a moving one
        times = np.cumsum(rng.uniform(0.05, 0.2, (N, n_points)), axis=1)
        q = rng.uniform(-1.0, 1.0, (N, n_points, 1))
        qd = rng.uniform(-1.0, 1.0, q.shape) if has_velocities else None
        refused = motions.start(
            rows, [1], now=np.full(N, now), times=times, positions=q, velocities=qd
        )
        assert refused is None
        splines = [
            spliced(spline, now, times[i], q[i, :, 0], None if qd is None else qd[i])
            for i, spline in enumerate(splines)
        ]
        for time in np.linspace(now, now + times.max() + 0.1, 40).tolist():
            position, velocity = motions.desired(rows, 1, np.full(N, time))
            samples = [spline.sample(time) for spline in splines]
            wanted = np.array([sample[:2] for sample in samples]).T
            np.testing.assert_allclose([position, velocity], wanted, atol=1e-12)
    still, speed = motions.desired(rows, 0, np.full(N, 9.0))
    assert (still == home[:, 0]).all()
    assert (speed == 0.0).all()


def test_a_motion_ends_as_in_the_tick() -> None:
    motions = Motions(np.zeros((1, 1)), [False])
    row, end = np.array([0]), 0.1
    motions.start(
        row,
        [0],
        now=np.zeros(1),
        times=np.array([[end]]),
        positions=np.array([[[1.0]]]),
        velocities=None,
    )
    for time, speed in ((end, 10.0), (math.nextafter(end, 1.0), 0.0)):
        position, velocity = motions.desired(row, 0, np.array([time]))
        assert position == pytest.approx([1.0])
        assert velocity == pytest.approx([speed])


def test_turning_joints_take_the_shorter_way() -> None:
    motions = Motions(np.array([[3.0, 3.0]]), [True, False])
    row = np.array([0])
    motions.start(
        row,
        [0, 1],
        now=np.zeros(1),
        times=np.array([[0.1, 0.2]]),
        positions=np.array([[[-3.0, -3.0], [-2.0, -2.0]]]),
        velocities=None,
    )
    turning, other = (motions.desired(row, k, np.ones(1))[0] for k in (0, 1))
    assert turning == pytest.approx([math.tau - 2.0])
    assert other == pytest.approx([-2.0])


def test_implausible_motions_change_nothing() -> None:
    motions = Motions(np.zeros((3, 1)), [False])
    positions = np.array([0.1, 0.1, 1e12]).reshape(3, 1, 1)
    refused = motions.start(
        np.arange(3),
        [0],
        now=np.zeros(3),
        times=np.full((3, 1), 0.1),
        positions=positions,
        velocities=None,
    )
    assert refused == 2
    position, _ = motions.desired(np.arange(3), 0, np.ones(3))
    assert (position == 0.0).all()


def test_others_keep_their_motion_when_some_rest() -> None:
    motions = Motions(np.zeros((3, 1)), [False])
    motions.start(
        np.arange(3),
        [0],
        now=np.zeros(3),
        times=np.full((3, 2), [0.1, 0.2]),
        positions=np.full((3, 2, 1), 0.5),
        velocities=np.zeros((3, 2, 1)),
    )
    motions.rest(np.array([1]), np.array([[0.2]]))
    position, _ = motions.desired(np.arange(3), 0, np.ones(3))
    assert position == pytest.approx([0.5, 0.2, 0.5])


def spliced(
    spline: JointSpline,
    now: float,
    times: np.ndarray,
    positions: np.ndarray,
    velocities: np.ndarray | None,
) -> JointSpline:
    """Return the spline that a JointTrajectoryController would follow then."""
    speeds = [None] * len(times) if velocities is None else velocities[:, 0].tolist()
    targets = [Motion(q, v) for q, v in zip(positions.tolist(), speeds, strict=True)]
    knots = Knots.of(list(zip(times.tolist(), targets, strict=True)))
    return spline.spliced(now, now, knots, suspects=range(1, len(times)))
