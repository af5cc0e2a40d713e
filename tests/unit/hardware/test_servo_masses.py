from __future__ import annotations

import numpy as np
import pytest

from tool0.hardware.servo_masses import (
    bounded_masses,
    integral_rate,
    largest_ratio,
)
from tool0.hardware.servos import INTEGRAL_RATE

OWN = np.array([[2.0, 0.3, 0.0], [0.3, 0.5, 0.01], [0.0, 0.01, 1e-3]])


def ratios(masses: np.ndarray) -> np.ndarray:
    """Return the generalised eigenvalues of ``masses`` and OWN."""
    return np.sort(np.linalg.eigvals(np.linalg.solve(OWN, masses)).real)


def test_masses_within_the_bounds_are_left_alone() -> None:
    declared = OWN + np.diag([1.0, 0.1, 1e-4])
    assert bounded_masses(OWN, declared, 5.0) is declared


@pytest.mark.parametrize("added", [-0.9, 0.5, 100.0])
def test_masses_stay_within_the_bounds(added: float) -> None:
    declared = OWN + np.diag([added, added, 0.3])
    found = bounded_masses(OWN, declared, 5.0)
    np.testing.assert_allclose(found, found.T, atol=1e-12)
    assert ratios(found)[0] >= 1.0 - 1e-9
    assert ratios(found)[-1] <= 5.0 + 1e-9


def test_a_light_direction_does_not_limit_the_others() -> None:
    declared = OWN + np.diag([2.0, 0.5, 1.0])
    found = bounded_masses(OWN, declared, 5.0)
    np.testing.assert_allclose(found[0, 0], declared[0, 0], rtol=0.02)
    assert found[2, 2] == pytest.approx(5.0 * OWN[2, 2], rel=0.3)


def test_longer_steps_permit_less() -> None:
    assert largest_ratio(0.001) > largest_ratio(0.002) > largest_ratio(0.1) == 1.0


def test_the_integral_is_slower_the_more_a_joint_may_carry() -> None:
    """Routh's criterion: the rate stays below 2 ζ ω times the smallest ratio."""
    assert integral_rate(4.0, 150.0, 0.001) == INTEGRAL_RATE
    assert integral_rate(1e-3, 28.0, 0.001) < integral_rate(0.05, 28.0, 0.001)
    assert integral_rate(1e-3, float("inf"), 0.001) == INTEGRAL_RATE
