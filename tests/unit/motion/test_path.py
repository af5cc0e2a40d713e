"""Laws of paths: what lies between their knots, and what is beside them."""

import numpy as np
import pytest

from tool0.control.spline import Motion, Segment
from tool0.motion.path import Path
from tool0.protocol.arm_motion import path_request
from tool0.simulation.paths import motion_plan, trajectory_points

RNG = np.random.default_rng(0)


def path(*, quintic: bool) -> Path:
    q, qd, qdd = RNG.uniform(-1.0, 1.0, (3, 4, 2))
    return Path(
        joint_names=("b", "a"),
        times=np.array([0.0, 0.5, 0.7, 2.0]),
        positions=q,
        velocities=qd,
        accelerations=qdd if quintic else None,
    )


def motion(path: Path, knot: int, joint: int) -> Motion:
    qdd = path.accelerations
    return Motion(
        float(path.positions[knot, joint]),
        float(path.velocities[knot, joint]),
        None if qdd is None else float(qdd[knot, joint]),
    )


@pytest.mark.parametrize("quintic", [False, True])
def test_between_its_knots_are_the_polynomials_of_a_controller(quintic: bool) -> None:
    way = path(quintic=quintic)
    for k, (start, end) in enumerate(zip(way.times, way.times[1:], strict=False)):
        times = np.linspace(start, end, 5)[1:-1]
        found = way.at(times)
        for joint in range(2):
            segment = Segment(
                start, motion(way, k, joint), end, motion(way, k + 1, joint)
            )
            q, qd, qdd = np.array([segment.sample(time) for time in times]).T
            np.testing.assert_allclose(found.positions[:, joint], q, atol=1e-12)
            np.testing.assert_allclose(found.velocities[:, joint], qd, atol=1e-11)
            if found.accelerations is not None:
                np.testing.assert_allclose(
                    found.accelerations[:, joint], qdd, atol=1e-10
                )


@pytest.mark.parametrize("quintic", [False, True])
def test_other_joints_stay_where_they_stand(quintic: bool) -> None:
    way = path(quintic=quintic)
    wide = way.beside({"a": 0.0, "rail": 0.25, "b": 0.0})
    assert wide.joint_names == ("a", "rail", "b")
    assert (wide.positions[:, 1] == 0.25).all()
    assert not wide.velocities[:, 1].any()
    np.testing.assert_array_equal(wide.positions[:, [2, 0]], way.positions)
    np.testing.assert_array_equal(wide.velocities[:, [2, 0]], way.velocities)
    assert way.beside({"b": 0.0, "a": 0.0}) is way


def test_a_path_without_its_first_knots_keeps_the_last() -> None:
    way = path(quintic=False)
    assert way.since(0.5).times.tolist() == [0.5, 0.7, 2.0]
    assert way.since(9.0).times.tolist() == [2.0]
    assert (way.since(9.0).positions[-1] == way.end).all()


@pytest.mark.parametrize("quintic", [False, True])
def test_every_form_of_a_path_has_its_numbers(quintic: bool) -> None:
    way = path(quintic=quintic)
    points, plan = trajectory_points(way), motion_plan(way)
    request = path_request("left", way, after=3, at=0.1)
    assert (request.arm, request.after, request.at) == ("left", 3, 0.1)
    assert request.times == tuple(way.times.tolist())
    assert len(points) == len(plan[0]) == len(way.times) - 1  # from the setpoint on
    for number, point in enumerate(points):
        assert point.time_from_start == way.times[number + 1]
        assert request.positions[number + 1] == point.positions
        assert request.velocities[number + 1] == point.velocities
        for joint in range(2):
            expected = motion(way, number + 1, joint)
            assert plan[joint][number] == (point.time_from_start, expected)
            assert point.positions[joint] == expected.position
    assert bool(request.accelerations) == quintic
    assert all((point.accelerations is not None) == quintic for point in points)
