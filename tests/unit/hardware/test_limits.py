from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tool0.description.drive_limits import DriveLimits
from tool0.description.loading import assemble
from tool0.description.model import JointLimits, SafetyController
from tool0.hardware.engine import JointState
from tool0.hardware.limits import (
    STOP_TOLERANCE,
    EffortLimiter,
    EffortLimits,
    velocity_window,
)

(GRIPPER,) = assemble("ur5", "2f85").model.grippers
HARD = JointLimits(lower=-1.0, upper=1.0, velocity=2.0, effort=10.0)
finite = st.floats(-100.0, 100.0)


def saturate(effort: float, position: float, velocity: float, **drive: object) -> float:
    limiter = EffortLimiter({0: EffortLimits(hard=HARD, **drive)}, 0.001)  # type: ignore[arg-type]
    efforts = [effort]
    limiter.saturate(efforts, JointState(0.0, [position], [velocity], [0.0]), [0.0])
    return efforts[0]


@given(finite, finite, finite)
def test_effort_never_exceeds_its_limit_nor_changes_sign(
    effort: float, position: float, velocity: float
) -> None:
    result = saturate(effort, position, velocity)
    assert abs(result) <= 10.0
    assert result * effort >= 0.0


@pytest.mark.parametrize(
    ("effort", "position", "velocity", "expected"),
    [
        (5.0, 0.0, 0.0, 5.0),
        (50.0, 0.0, 0.0, 10.0),
        (5.0, 1.0 + 2 * STOP_TOLERANCE, 0.0, 0.0),
        (-5.0, 1.0 + 2 * STOP_TOLERANCE, 0.0, -5.0),
        (-5.0, -1.0 - 2 * STOP_TOLERANCE, 0.0, 0.0),
        (5.0, 0.0, 2.1, 0.0),
        (-5.0, 0.0, 2.1, -5.0),
        (-5.0, 0.0, -2.1, 0.0),
    ],
)
def test_effort_ends_where_ros_control_ends_it(
    effort: float, position: float, velocity: float, expected: float
) -> None:
    assert saturate(effort, position, velocity) == expected


@pytest.mark.parametrize("inertia", [0.0, 0.01])
def test_drive_limits_hold_and_are_lifted(inertia: float) -> None:
    limiter = EffortLimiter({0: EffortLimits(hard=HARD, inertia=inertia)}, 0.001)
    still = JointState(0.0, [0.0], [0.0], [0.0])

    def given() -> float:
        efforts = [50.0]
        limiter.saturate(efforts, still, [0.0])
        return efforts[0]

    for effort, expected in ((3.0, 3.0), (30.0, 10.0)):
        limiter.set_drive_limits(0, DriveLimits(gripper=GRIPPER, effort=effort))
        assert given() == expected
        assert list(limiter.drive_limits) == [0]
    limiter.set_drive_limits(0, None)
    assert given() == 10.0
    limiter.set_drive_limits(0, DriveLimits(gripper=GRIPPER, effort=1.0))
    limiter.restart()
    assert (given(), dict(limiter.drive_limits)) == (10.0, {})


def test_soft_limits_brake_before_the_stop() -> None:
    soft = SafetyController(
        soft_lower_limit=-0.8, soft_upper_limit=0.8, k_position=20.0, k_velocity=50.0
    )
    assert saturate(5.0, 0.0, 0.0, soft=soft) == 5.0
    assert saturate(5.0, 0.8, 0.0, soft=soft) == pytest.approx(0.0)
    assert saturate(5.0, 0.9, 0.0, soft=soft) < 0.0


def test_a_k_velocity_of_zero_does_not_make_the_joint_limp() -> None:
    soft = SafetyController(
        soft_lower_limit=-0.8, soft_upper_limit=0.8, k_position=20.0, k_velocity=0.0
    )
    assert saturate(5.0, 0.0, 0.0, soft=soft) == 5.0


def test_the_velocity_window_closes_at_the_soft_limit() -> None:
    soft = SafetyController(
        soft_lower_limit=-0.8, soft_upper_limit=0.8, k_position=20.0
    )
    assert velocity_window(0.0, HARD, soft) == (-2.0, 2.0)
    assert velocity_window(0.8, HARD, soft)[1] == pytest.approx(0.0)
    assert velocity_window(0.0, HARD, None) == (-2.0, 2.0)
    assert velocity_window(0.0, JointLimits(), None) == (-math.inf, math.inf)
