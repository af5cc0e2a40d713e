"""Smooth motions through waypoints: limits are kept, corners are near."""

from __future__ import annotations

import numpy as np
import pytest

from tool0.description.loading import assemble
from tool0.kinematics.chain import Array, find_chains
from tool0.motion.rules import TIME_TO_FULL_ACCELERATION
from tool0.motion.waypoints import SmoothWay, time_way

(CHAIN,) = find_chains(assemble("ur5", gripper=None).model).values()
JOINTS = CHAIN.joints


def ways() -> list[Array]:
    rng = np.random.default_rng(3)
    return [
        np.cumsum(rng.normal(scale=scale, size=(n, 6)), axis=0)
        for n, scale in ((2, 1.0), (3, 0.7), (6, 0.5), (12, 0.1), (2, 1e-4))
    ]


@pytest.mark.parametrize("speed", [0.1, 1.0])
def test_no_joint_exceeds_its_limits(speed: float) -> None:
    for poses in ways():
        path = time_way(JOINTS, SmoothWay(poses, [0.2] * (len(poses) - 2)), speed=speed)
        dense = path.at(np.linspace(0.0, path.duration, 4000))
        assert dense.accelerations is not None
        for k, joint in enumerate(JOINTS):
            strongest = joint.max_acceleration
            fastest = speed * joint.max_velocity
            jerk = min(strongest / TIME_TO_FULL_ACCELERATION, joint.limits.jerk)
            # at the knots the limits are kept; between them, quintics deviate a little
            assert np.abs(path.velocities[:, k]).max() <= fastest + 1e-9
            assert np.abs(path.accelerations[:, k]).max() <= strongest + 1e-9
            assert np.abs(dense.velocities[:, k]).max() <= 1.01 * fastest
            assert np.abs(dense.accelerations[:, k]).max() <= 1.1 * strongest
            steps = np.diff(path.accelerations[:, k]) / np.diff(path.times)
            assert np.abs(steps).max() <= jerk + 1e-6


def test_a_straight_motion_reaches_full_speed() -> None:
    poses = np.array([np.zeros(6), np.full(6, 3.0)])
    path = time_way(JOINTS, SmoothWay(poses, []), speed=1.0)
    assert np.abs(path.velocities).max() == pytest.approx(
        JOINTS[0].max_velocity, rel=0.01
    )


def test_it_starts_and_ends_at_rest_at_the_ends() -> None:
    for poses in ways():
        path = time_way(JOINTS, SmoothWay(poses, [0.1] * (len(poses) - 2)), speed=0.5)
        np.testing.assert_allclose(path.positions[0], poses[0], atol=1e-9)
        np.testing.assert_allclose(path.positions[-1], poses[-1], atol=1e-12)
        for values in (path.velocities, path.accelerations):
            assert values is not None
            np.testing.assert_array_equal(values[[0, -1]], 0.0)


@pytest.mark.parametrize("deviation", [0.0, 0.05, 0.2])
def test_corners_are_cut_by_no_more_than_the_deviation(deviation: float) -> None:
    for poses in ways():
        way = SmoothWay(poses, [deviation] * (len(poses) - 2))
        blends = dict(way.blends(32))
        assert sorted(blends) == (list(range(len(poses) - 2)) if deviation else [])
        for number, blend in blends.items():
            nearest = np.linalg.norm(blend - poses[1 + number], axis=1).min()
            assert 0.0 < nearest <= deviation + 1e-9
        if deviation == 0.0 and len(poses) > 2:
            path = time_way(JOINTS, way, speed=1.0)
            for corner in poses[1:-1]:  # it stops there
                k = np.linalg.norm(path.positions - corner, axis=1).argmin()
                assert np.abs(path.velocities[k]).max() < 0.3
