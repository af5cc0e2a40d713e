from __future__ import annotations

import numpy as np
import pytest

from tool0.hardware.speed_governor import (
    FAST,
    LARGEST_TURN,
    GovernedDrive,
    SpeedGovernor,
)

DT = 1e-3
MASSES = np.array([[2.0, 0.3, 0.02], [0.3, 0.5, 0.03], [0.02, 0.03, 0.05]])
SPEEDS = (3.0, 3.0, 6.0)
EFFORTS = (150.0, 60.0, 20.0)


def governor() -> SpeedGovernor:
    made = SpeedGovernor()
    drives = [
        GovernedDrive(i, speed, FAST * speed, effort)
        for i, (speed, effort) in enumerate(zip(SPEEDS, EFFORTS, strict=True))
    ]
    made.choose(drives, [0, 1, 2])
    return made


AT = [0.1, 0.2, 0.3]
"""Positions of the joints [rad]."""


def test_a_mobility_holds_near_the_posture_it_was_computed_at() -> None:
    made = governor()
    assert made.is_mobility_due(AT)
    made.update(np.eye(3).tolist(), AT)
    near, far = ([q + share * LARGEST_TURN for q in AT] for share in (0.99, 1.01))
    assert not made.is_mobility_due(near)
    assert made.is_mobility_due(far)


def largest_share(masses: np.ndarray, seed: int) -> float:
    """Return the largest speed ÷ limit under random efforts and constant loads."""
    rng = np.random.default_rng(seed)
    made, largest = governor(), 0.0
    v, applied = np.zeros(3), [0.0] * 3
    bias = rng.uniform(-0.3, 0.3, 3) * EFFORTS
    for k in range(3000):
        if k % 40 == 0:
            wanted = rng.uniform(-3.0, 3.0, 3) * EFFORTS
        effort = wanted.tolist()
        if made.is_fast(v.tolist()):
            if made.is_mobility_due(AT):
                made.update((DT * np.linalg.inv(MASSES)).tolist(), AT)
            made.limit(effort, applied, v.tolist())
        made.note(v.tolist())
        effort = np.clip(effort, [-u for u in EFFORTS], EFFORTS).tolist()
        v = v + DT * np.linalg.solve(masses, np.array(effort) - bias)
        applied = effort
        largest = max(largest, float(np.abs(v / SPEEDS).max()))
    return largest


@pytest.mark.parametrize("seed", range(3))
def test_joints_that_fling_each_other_keep_to_their_speeds(seed: int) -> None:
    assert 0.95 < largest_share(MASSES, seed) < 1.01


@pytest.mark.parametrize("seed", range(3))
def test_a_load_that_it_does_not_know_slows_the_joints_down(seed: int) -> None:
    assert largest_share(MASSES + np.diag([2.0, 0.5, 0.05]), seed) < 1.1


def test_efforts_that_exceed_no_speed_are_left_alone() -> None:
    made, effort = governor(), [20.0, -10.0, 3.0]
    made.update((DT * np.linalg.inv(MASSES)).tolist(), AT)
    made.note([2.0, 0.0, 0.0])
    made.limit(effort, [0.0] * 3, [2.0, 0.0, 0.0])
    assert effort == [20.0, -10.0, 3.0]


def test_a_joint_beyond_its_speed_is_braked() -> None:
    made, effort = governor(), [100.0, 0.0, 0.0]
    made.update((DT * np.linalg.inv(MASSES)).tolist(), AT)
    made.note([4.0, 0.0, 0.0])
    made.limit(effort, [0.0] * 3, [4.0, 0.0, 0.0])
    assert effort[0] == pytest.approx(-EFFORTS[0])
