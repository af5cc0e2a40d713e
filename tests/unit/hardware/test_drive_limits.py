"""Speed and force at the pads, and a rotor under a drive that keeps to them."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tool0.description.drive_limits import DriveLimits
from tool0.description.loading import assemble
from tool0.description.model import JointLimits
from tool0.errors import ControlError
from tool0.hardware.limits import EASE, SpeedLimiter

(GRIPPER,) = assemble("ur5", "2f85").model.grippers
HARD = JointLimits(lower=0.0, upper=0.8133, velocity=1.75, effort=26.8)
ARMATURE, DT = 0.0122, 0.001
FINGERS = 0.0008
"""What turns with the rotor without the drive's knowledge [kg·m²]."""
POSITION = 0.4
positions = st.floats(0.0, 0.8133)
LEVER = GRIPPER.lever(POSITION)


@given(positions, st.floats(20.0, 235.0), st.floats(0.02, 0.15))
def test_virtual_work_relates_pads_and_joint(
    position: float, force: float, speed: float
) -> None:
    limits = DriveLimits(gripper=GRIPPER, force=force, speed=speed)
    effort, velocity = limits.at(position)
    assert effort * velocity == pytest.approx(force * speed)
    h = 1e-6
    way = GRIPPER.opening(position - h) - GRIPPER.opening(position + h)
    assert effort == pytest.approx(force * way / (2.0 * h), rel=1e-6)


@given(positions)
def test_what_is_left_out_does_not_bound(position: float) -> None:
    assert DriveLimits(gripper=GRIPPER).at(position) == (math.inf, math.inf)
    assert DriveLimits(gripper=GRIPPER, effort=3.0).at(position) == (3.0, math.inf)


@pytest.mark.parametrize(
    "settings",
    [
        *({"force": f} for f in (0.0, 19.9, 235.1, -50.0, math.nan, math.inf)),
        *({"speed": v} for v in (0.0, 0.019, 0.151, -0.1, math.nan, math.inf)),
        *({"effort": tau} for tau in (0.0, -1.0, math.nan, math.inf)),
        {"force": 50.0, "effort": 2.0},
    ],
)
def test_what_the_gripper_cannot_do_is_refused(settings: dict[str, float]) -> None:
    with pytest.raises(ControlError) as error:
        DriveLimits(gripper=GRIPPER, **settings)
    assert all(f"{value}" in str(error.value) for value in settings.values())


def press(
    drive: SpeedLimiter,
    wanted: float,
    applied: float,
    *,
    velocity: float = 0.0,
    gravity: float = 0.0,
) -> float:
    """Return the effort of the next step [N·m]."""
    return drive.limit(
        wanted, applied=applied, gravity=gravity, position=POSITION, velocity=velocity
    )


def turn(
    drive: SpeedLimiter,
    wanted: float,
    resist: Callable[[int, float], float],
    *,
    steps: int = 300,
    gravity: float = 0.0,
) -> tuple[list[float], list[float]]:
    """Return speeds [rad/s] and efforts [N·m] of a rotor that is resisted so."""
    velocity, applied = 0.0, 0.0
    velocities, efforts = [], []
    for k in range(steps):
        applied = press(drive, wanted, applied, velocity=velocity, gravity=gravity)
        velocity += (applied - resist(k, velocity)) / (ARMATURE + FINGERS) * DT
        velocities.append(velocity)
        efforts.append(applied)
    return velocities, efforts


def limited(**settings: float) -> SpeedLimiter:
    drive = SpeedLimiter(HARD, inertia=ARMATURE, dt=DT)
    drive.drive_limits = DriveLimits(gripper=GRIPPER, **settings)
    return drive


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("speed", [0.02, 0.15])
@pytest.mark.parametrize("friction", [0.0, 0.2, 2.0])  # [N·m·s/rad]
def test_it_keeps_the_speed_against_friction(
    sign: float, speed: float, friction: float
) -> None:
    drive = limited(speed=speed, force=235.0)
    velocities, _ = turn(drive, sign * 20.0, lambda _, v: friction * v)
    near = 1e-3 if friction else 0.1  # nothing slows it down
    assert sign * velocities[-1] == pytest.approx(speed / LEVER, rel=near)
    assert max(sign * v for v in velocities) <= 1.1 * speed / LEVER


@pytest.mark.parametrize("speed", [0.02, 0.15])
@pytest.mark.parametrize("force", [20.0, 235.0])
def test_what_stops_it_is_pressed_with_the_force_whatever_the_speed(
    speed: float, force: float
) -> None:
    drive = limited(speed=speed, force=force)
    applied = 0.0
    for _ in range(50):
        applied = press(drive, 26.8, applied)
    assert applied == pytest.approx(force * LEVER)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_weaker_setting_is_reached_step_by_step(sign: float) -> None:
    drive, applied, efforts = limited(force=235.0), 0.0, []

    for k in range(60):
        if k == 5:
            drive.drive_limits = DriveLimits(gripper=GRIPPER, force=20.0)
        applied = press(drive, sign * 26.8, applied)
        efforts.append(sign * applied)
    firm, *eased = efforts[4:]
    assert firm == pytest.approx(235.0 * LEVER)
    steps = -np.diff([firm, *eased])
    assert max(steps) == pytest.approx(HARD.effort * DT / EASE)
    assert min(steps) >= 0.0
    assert eased[-1] == pytest.approx(20.0 * LEVER)


def test_the_weight_of_the_fingers_is_no_part_of_the_force() -> None:
    drive = limited(force=20.0)
    for gravity in (0.07, -0.07):
        for wanted in (20.0, -20.0):
            effort = 0.0
            for _ in range(20):
                effort = press(drive, wanted, effort, gravity=gravity)
            assert abs(effort - gravity) == pytest.approx(20.0 * LEVER)


def test_when_it_comes_free_it_soon_runs_at_the_speed() -> None:
    drive, velocity, applied = limited(speed=0.05, force=100.0), 0.0, 0.0
    for _ in range(100):  # squeezing
        applied = press(drive, 20.0, applied)
    pushes = 0
    for _ in range(300):
        applied = press(drive, 20.0, applied, velocity=velocity)
        pushes += applied > 1.0
        velocity += (applied - 0.2 * velocity) / (ARMATURE + FINGERS) * DT
    assert pushes <= 1, "one step at full effort, before it is known"
    assert velocity == pytest.approx(0.05 / LEVER, rel=0.01)


def test_weight_that_runs_away_is_held_back() -> None:
    gravity = -0.3  # the weight closes the fingers
    drive = limited(speed=0.02)
    velocities, _ = turn(drive, 1.0, lambda _, v: gravity + 0.2 * v, gravity=gravity)
    assert velocities[-1] == pytest.approx(0.02 / LEVER, rel=1e-2)


def test_without_settings_it_keeps_to_the_joint_s_limits() -> None:
    drive = SpeedLimiter(HARD, inertia=ARMATURE, dt=DT)
    velocities, efforts = turn(drive, 100.0, lambda _, v: 0.2 * v)
    assert max(efforts) <= HARD.effort
    assert max(velocities) <= 1.1 * HARD.velocity
    assert velocities[-1] == pytest.approx(HARD.velocity, rel=1e-3)


def test_without_a_rotor_s_inertia_it_lets_go_above_the_speed() -> None:
    drive = SpeedLimiter(HARD, inertia=0.0, dt=DT)
    drive.drive_limits = DriveLimits(gripper=GRIPPER, speed=0.1, force=50.0)
    for velocity, wanted, expected in (
        (0.0, 20.0, 50.0 * LEVER),
        (1.1 * 0.1 / LEVER, 20.0, 0.0),
        (1.1 * 0.1 / LEVER, -1.0, -1.0),
        (-1.1 * 0.1 / LEVER, -1.0, 0.0),
    ):
        given = press(drive, wanted, 0.0, velocity=velocity)
        assert given == pytest.approx(expected)
