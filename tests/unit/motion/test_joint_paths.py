"""Laws of paths of joints, sampled as the controllers play them."""

import math
import subprocess
import sys

import numpy as np
import pytest

from tool0.control.spline import JointSpline, Knots, Motion, Segment, point_to_point
from tool0.description.model import (
    DEFAULT_SLIDE_VELOCITY,
    DEFAULT_TURN_VELOCITY,
    TIME_TO_FULL_SPEED,
    Joint,
    JointLimits,
    JointType,
)
from tool0.errors import ControlError
from tool0.motion.joint import SPACING, plan_cubic, plan_joints
from tool0.motion.path import Path
from tool0.protocol.trajectories import JointsMotion
from tool0.simulation.paths import motion_plan

pytestmark = pytest.mark.slow


def joint(
    name: str,
    kind: JointType = JointType.REVOLUTE,
    *,
    reach: float = 3.0,
    velocity: float = math.inf,
) -> Joint:
    limits = JointLimits(lower=-reach, upper=reach, velocity=velocity)
    return Joint(name=name, type=kind, parent="a", child="b", limits=limits)


ARM = (
    joint("a", velocity=3.14),
    joint("b", velocity=2.0),
    joint("rail", JointType.PRISMATIC, reach=0.8, velocity=0.2),
    joint("c", velocity=6.28),
)
REACH = np.array([item.limits.upper for item in ARM])
FASTEST = np.array([item.limits.velocity for item in ARM])


def moving(positions, velocities=None, accelerations=None) -> JointsMotion:
    still = [0.0] * len(positions)
    return JointsMotion(
        positions=tuple(positions),
        velocities=tuple(still if velocities is None else velocities),
        accelerations=tuple(still if accelerations is None else accelerations),
    )


def as_played(start: JointsMotion, plan: Path) -> list[JointSpline]:
    """Return the splines that a trajectory controller makes of the plan."""
    splines = []
    first = zip(start.positions, start.velocities, start.accelerations, strict=True)
    for motion, path in zip(first, motion_plan(plan), strict=True):
        before = point_to_point(-1.0, Motion(*motion), 1.0, Motion(*motion))
        suspects = range(1, len(path))
        splines.append(before.spliced(0.0, 0.0, Knots.of(path), suspects=suspects))
    return splines


def last(plan: Path) -> tuple[float, ...]:
    """Return where the joints come to rest; they do."""
    assert plan.accelerations is not None
    assert not plan.velocities[-1].any()
    assert not plan.accelerations[-1].any()
    return tuple(plan.end.tolist())


def sampled(start: JointsMotion, plan: Path, dt: float = 5e-4):
    """Return times, positions, velocities, accelerations; shape (n, n_joints)."""
    end = plan.duration
    times = np.append(np.arange(0.0, end, dt), end)
    splines = as_played(start, plan)
    samples = np.array([[each.sample(time) for each in splines] for time in times])
    return times, samples[..., 0], samples[..., 1], samples[..., 2]


def random_place(rng: np.random.Generator) -> np.ndarray:
    return rng.uniform(-REACH, REACH)


@pytest.mark.parametrize("seed", range(10))
def test_from_rest_it_is_a_straight_line_within_the_limits(seed: int) -> None:
    rng = np.random.default_rng(seed)
    start, ends = moving(random_place(rng)), random_place(rng)
    speed = float(rng.choice([0.01, 0.1, 0.5, 1.0]))
    plan = plan_joints(ARM, start, ends, speed=speed)
    _, q, qd, _ = sampled(start, plan, dt=5e-3 / speed)
    assert (abs(qd) <= 1.001 * speed * FASTEST).all()
    assert last(plan) == tuple(ends)
    done = (q - start.positions) / (ends - np.array(start.positions))
    assert (done >= -1e-6).all()
    assert (done <= 1.0 + 1e-6).all()
    straight = np.broadcast_to(done[:, :1], done.shape)
    np.testing.assert_allclose(done, straight, atol=1e-6)


@pytest.mark.parametrize("seed", range(15))
def test_from_any_motion_it_goes_on_smoothly(seed: int) -> None:
    rng = np.random.default_rng(seed)
    most = FASTEST / TIME_TO_FULL_SPEED
    start = moving(
        random_place(rng) / 3.0,
        rng.uniform(-0.5, 0.5, 4) * FASTEST,
        rng.uniform(-1.0, 1.0, 4) * most,
    )
    plan = plan_joints(ARM, start, random_place(rng), speed=1.0)
    times, q, qd, qdd = sampled(start, plan)
    assert (abs(qd) <= 1.02 * FASTEST).all()
    assert (abs(q) <= REACH + 1e-6).all()
    steps = np.diff(times)[:, np.newaxis]
    np.testing.assert_allclose(np.diff(q, axis=0) / steps, qd[:-1], atol=0.01)
    assert (abs(np.diff(qd, axis=0)) <= 1.1 * most * steps + 1e-9).all()
    assert (abs(np.diff(qdd, axis=0)) <= 1.1 * 10.0 * most * steps + 1e-6).all()


def test_a_joint_keeps_to_its_own_acceleration_and_jerk() -> None:
    most, jerk = 0.5, 2.0
    limits = JointLimits(lower=-3, upper=3, velocity=2, acceleration=most, jerk=jerk)
    slow = Joint(
        name="slow", type=JointType.REVOLUTE, parent="a", child="b", limits=limits
    )
    start = moving([0.0, 0.0])
    plan = plan_joints((ARM[0], slow), start, [1.0, 1.0], speed=1.0)
    times, _, _, qdd = sampled(start, plan)
    steps = np.diff(times)[:, np.newaxis]
    assert 0.9 * most < abs(qdd[:, 1]).max() < 1.01 * most
    assert (abs(np.diff(qdd, axis=0)) <= 1.1 * jerk * steps + 1e-6).all()


def test_full_speed_comes_after_about_the_time_for_it() -> None:
    start = moving([-3.0] * 2 + [0.0] * 2)
    plan = plan_joints(ARM, start, [3.0, -3.0, 0.0, 0.0], speed=1.0)
    times, _, qd, _ = sampled(start, plan)
    at_full = times[np.argmax(qd[:, 0] >= 0.999 * FASTEST[0])]
    assert 0.35 <= at_full <= 0.55


def test_an_empty_way_is_one_instant_that_holds() -> None:
    place = (0.1, 0.2, 0.3, 0.4)
    plan = plan_joints(ARM, moving(place), place, speed=0.5)
    assert plan.times.tolist() == [0.0, SPACING]
    assert plan.positions.tolist() == [list(place)] * 2
    assert last(plan) == place


def test_beyond_the_speed_that_is_asked_it_slows_down_first() -> None:
    for excess in (1.0 + 1e-12, 1.0001, 1.05, 3.0):
        speeds = 0.1 * FASTEST * excess * np.array([1, -1, 1, -1])
        start = moving([0.0] * 4, speeds)
        plan = plan_joints(ARM, start, [0.5, 0.5, 0.5, 0.5], speed=0.1)
        times, _, qd, _ = sampled(start, plan, dt=0.005)
        assert (abs(qd) <= 1.0001 * abs(speeds)).all()
        assert (abs(qd[times > 0.5]) <= 1.001 * 0.1 * FASTEST).all()
        assert last(plan) == (0.5,) * 4


def test_too_fast_to_stop_before_the_limit_it_brakes_harder() -> None:
    start = moving([2.9, 0.0, 0.0, 0.0], [3.0, 0.0, 0.0, 0.0])
    plan = plan_joints(ARM, start, [1.0, 1.0, 0.1, 1.0], speed=1.0)
    _, q, _, _ = sampled(start, plan, dt=1e-4)
    assert q[:, 0].max() <= 3.0 + 1e-5
    assert last(plan) == (1.0, 1.0, 0.1, 1.0)


def test_a_start_beyond_the_limits_comes_back() -> None:
    plan = plan_joints(ARM, moving([3.001, 0, 0, 0]), [2.5, 0, 0, 0], speed=0.5)
    assert np.abs(plan.positions[1:, 0]).max() <= 3.0


def test_a_continuous_joint_goes_the_shortest_way_round() -> None:
    wheel = joint("wheel", JointType.CONTINUOUS, reach=math.inf, velocity=1.0)
    plan = plan_joints([wheel], moving([20.0]), [0.0], speed=1.0)
    assert last(plan) == pytest.approx((6 * math.pi,))


@pytest.mark.parametrize(
    ("kind", "fastest"),
    [
        (JointType.REVOLUTE, DEFAULT_TURN_VELOCITY),
        (JointType.PRISMATIC, DEFAULT_SLIDE_VELOCITY),
    ],
)
def test_joints_without_a_velocity_get_a_modest_one(
    kind: JointType, fastest: float
) -> None:
    start = moving([-3.0])
    plan = plan_joints([joint("x", kind)], start, [3.0], speed=1.0)
    _, _, qd, _ = sampled(start, plan)
    assert qd.max() == pytest.approx(fastest)


@pytest.mark.parametrize("speed", [0.0, 0.009, 1.01, -1.0, math.nan, math.inf])
def test_a_speed_out_of_range_is_refused(speed: float) -> None:
    with pytest.raises(ControlError):
        plan_joints(ARM, moving([0.0] * 4), [0.0] * 4, speed=speed)


def test_the_planner_s_library_is_not_imported_before_it_is_needed() -> None:
    code = "import tool0.motion.joint, sys; sys.exit('ruckig' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize("seed", range(4))
def test_a_goal_that_accelerates_too_much_is_left_within_the_speed_limits(
    seed: int,
) -> None:
    """A user's goal may accelerate 20 times as much as a planned motion."""
    rng = np.random.default_rng(seed)
    for _ in range(20):
        velocities = rng.uniform(-0.9, 0.9, 4) * FASTEST
        accelerations = rng.uniform(-20.0, 20.0, 4) * FASTEST
        here, target = 0.2 * rng.uniform(-1.0, 1.0, (2, 4)) * REACH
        start = moving(here, velocities, accelerations)
        plan = plan_joints(ARM, start, target, speed=rng.uniform(0.05, 1.0))
        _, _, speeds, _ = sampled(start, plan, 2e-3)
        assert (np.abs(speeds).max(axis=0) <= 1.02 * FASTEST).all()
        assert last(plan) == pytest.approx(tuple(target))


def test_a_goal_much_too_fast_is_left_for_another_target() -> None:
    """The planner's library fails with codes that it has no name for, or a day long."""
    rng = np.random.default_rng(1)
    for _ in range(300):
        share = rng.uniform(0.2, 0.8)
        way = rng.uniform(-1.0, 1.0, 4) * REACH
        quintic = point_to_point(0.0, Motion(0.0, 0.0, 0.0), 0.15, Motion(1.0, 0, 0))
        q, qd, qdd = quintic.sample(0.15 * share)
        start = moving(q * way, qd * way, qdd * way)
        target = 0.5 * rng.uniform(-1.0, 1.0, 4) * REACH
        plan = plan_joints(
            ARM, start, target, speed=float(rng.choice([0.05, 0.1, 1.0]))
        )
        assert plan.duration < 300.0


@pytest.mark.parametrize("seed", range(3))
def test_the_path_is_what_a_controller_plays(seed: int) -> None:
    rng = np.random.default_rng(seed)
    start = moving(random_place(rng) / 3.0, rng.uniform(-0.5, 0.5, 4) * FASTEST)
    plan = plan_joints(ARM, start, random_place(rng), speed=1.0)
    times, q, qd, qdd = sampled(start, plan)
    found = plan.at(times)
    np.testing.assert_allclose(found.positions, q, atol=1e-9)
    np.testing.assert_allclose(found.velocities, qd, atol=1e-7)
    np.testing.assert_allclose(found.accelerations, qdd, atol=1e-4)


@pytest.mark.parametrize("duration", [0.2, 3.0])
def test_a_cubic_is_refused_by_its_largest_velocity(duration: float) -> None:
    rng = np.random.default_rng(5)
    for _ in range(50):
        q0, qd0, q1 = rng.uniform(-2.0, 2.0, 3)
        cubic = Segment(0.0, Motion(q0, qd0), duration, Motion(q1, 0.0))
        times = np.linspace(0.0, duration, 2001)
        densest = max(abs(cubic.sample(time).velocity) for time in times)
        start = moving([q0], [qd0])
        enough = joint("a", velocity=1.001 * densest)
        assert plan_cubic([enough], start, [q1], duration).duration == duration
        if densest > 1.01 * abs(qd0):
            short = joint("a", velocity=0.99 * densest)
            with pytest.raises(ControlError, match="at least"):
                plan_cubic([short], start, [q1], duration)
