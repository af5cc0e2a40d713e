"""A rotor and what holds it back, under a drive that keeps to a speed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tool0.description.catalogue import assemble
from tool0.description.model import JointLimits
from tool0.hardware.drive_limits import DriveLimits
from tool0.hardware.regulated_drive import EASE, RegulatedDrive

(GRIPPER,) = assemble("ur5", "2f85").model.grippers
HARD = JointLimits(lower=0.0, upper=0.8133, velocity=1.75, effort=26.8)
ARMATURE, DT = 0.0122, 0.001
FINGERS = 0.0008
"""What turns with the rotor without the drive's knowledge [kg·m²]."""
POSITION = 0.4
LEVER = GRIPPER.lever(POSITION)


def turn(
    drive: RegulatedDrive,
    wanted: float,
    resist: Callable[[int, float], float],
    *,
    steps: int = 300,
    load: float = 0.0,
) -> tuple[list[float], list[float]]:
    """Return speeds [rad/s] and efforts [N·m] of a rotor that is resisted so."""
    velocity, applied = 0.0, 0.0
    velocities, efforts = [], []
    for k in range(steps):
        applied = drive.bound(
            wanted, applied=applied, load=load, position=POSITION, velocity=velocity
        )
        velocity += (applied - resist(k, velocity)) / (ARMATURE + FINGERS) * DT
        velocities.append(velocity)
        efforts.append(applied)
    return velocities, efforts


def bounded(**settings: float) -> RegulatedDrive:
    drive = RegulatedDrive(HARD, armature=ARMATURE, dt=DT)
    drive.bounds = DriveLimits(gripper=GRIPPER, **settings)
    return drive


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("speed", [0.02, 0.15])
@pytest.mark.parametrize("friction", [0.0, 0.2, 2.0])  # [N·m·s/rad]
def test_it_keeps_the_speed_against_friction(
    sign: float, speed: float, friction: float
) -> None:
    drive = bounded(speed=speed, force=235.0)
    velocities, _ = turn(drive, sign * 20.0, lambda _, v: friction * v)
    near = 1e-3 if friction else 0.1  # nothing slows it down
    assert sign * velocities[-1] == pytest.approx(speed / LEVER, rel=near)
    assert max(sign * v for v in velocities) <= 1.1 * speed / LEVER


@pytest.mark.parametrize("speed", [0.02, 0.15])
@pytest.mark.parametrize("force", [20.0, 235.0])
def test_what_stops_it_is_pressed_with_the_force_whatever_the_speed(
    speed: float, force: float
) -> None:
    drive = bounded(speed=speed, force=force)
    velocity, applied = 0.0, 0.0
    for _ in range(50):
        applied = drive.bound(
            26.8, applied=applied, load=0.0, position=POSITION, velocity=velocity
        )
    assert applied == pytest.approx(force * LEVER)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_weaker_setting_is_reached_step_by_step(sign: float) -> None:
    drive, applied, efforts = bounded(force=235.0), 0.0, []

    def press(wanted: float) -> float:
        return drive.bound(
            wanted, applied=applied, load=0.0, position=POSITION, velocity=0.0
        )

    for k in range(60):
        if k == 5:
            drive.bounds = DriveLimits(gripper=GRIPPER, force=20.0)
        applied = press(sign * 26.8)
        efforts.append(sign * applied)
    firm, *eased = efforts[4:]
    assert firm == pytest.approx(235.0 * LEVER)
    steps = -np.diff([firm, *eased])
    assert max(steps) == pytest.approx(HARD.effort * DT / EASE)
    assert min(steps) >= 0.0
    assert eased[-1] == pytest.approx(20.0 * LEVER)


def test_the_weight_of_the_fingers_is_no_part_of_the_force() -> None:
    drive = bounded(force=20.0)
    for load in (0.07, -0.07):
        for wanted in (20.0, -20.0):
            effort = 0.0
            for _ in range(20):
                effort = drive.bound(
                    wanted, applied=effort, load=load, position=POSITION, velocity=0.0
                )
            assert abs(effort - load) == pytest.approx(20.0 * LEVER)


def test_when_it_comes_free_it_soon_runs_at_the_speed() -> None:
    drive, velocity, applied = bounded(speed=0.05, force=100.0), 0.0, 0.0
    for _ in range(100):  # squeezing
        applied = drive.bound(
            20.0, applied=applied, load=0.0, position=POSITION, velocity=0.0
        )
    pushes = 0
    for _ in range(300):
        applied = drive.bound(
            20.0, applied=applied, load=0.0, position=POSITION, velocity=velocity
        )
        pushes += applied > 1.0
        velocity += (applied - 0.2 * velocity) / (ARMATURE + FINGERS) * DT
    assert pushes <= 1, "one step at full effort, before it is known"
    assert velocity == pytest.approx(0.05 / LEVER, rel=0.01)


def test_weight_that_runs_away_is_held_back() -> None:
    load = -0.3  # the weight closes the fingers
    drive = bounded(speed=0.02)
    velocities, _ = turn(drive, 1.0, lambda _, v: load + 0.2 * v, load=load)
    assert velocities[-1] == pytest.approx(0.02 / LEVER, rel=1e-2)


def test_without_settings_it_keeps_to_the_joint_s_limits() -> None:
    drive = RegulatedDrive(HARD, armature=ARMATURE, dt=DT)
    velocities, efforts = turn(drive, 100.0, lambda _, v: 0.2 * v)
    assert max(efforts) <= HARD.effort
    assert max(velocities) <= 1.1 * HARD.velocity
    assert velocities[-1] == pytest.approx(HARD.velocity, rel=1e-3)


def test_without_a_rotor_s_inertia_it_lets_go_above_the_speed() -> None:
    drive = RegulatedDrive(HARD, armature=0.0, dt=DT)
    drive.bounds = DriveLimits(gripper=GRIPPER, speed=0.1, force=50.0)
    for velocity, wanted, expected in (
        (0.0, 20.0, 50.0 * LEVER),
        (1.1 * 0.1 / LEVER, 20.0, 0.0),
        (1.1 * 0.1 / LEVER, -1.0, -1.0),
        (-1.1 * 0.1 / LEVER, -1.0, 0.0),
    ):
        given = drive.bound(
            wanted, applied=0.0, load=0.0, position=POSITION, velocity=velocity
        )
        assert given == pytest.approx(expected)
