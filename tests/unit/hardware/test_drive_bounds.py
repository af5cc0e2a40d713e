"""Speed and force at the pads, as bounds of the joint that drives them."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tool0.description.catalogue import assemble
from tool0.errors import ControlError
from tool0.hardware.drive_limits import DriveLimits

(GRIPPER,) = assemble("ur5", "2f85").model.grippers
positions = st.floats(0.0, 0.8133)


@given(positions, st.floats(20.0, 235.0), st.floats(0.02, 0.15))
def test_virtual_work_relates_pads_and_joint(
    position: float, force: float, speed: float
) -> None:
    bounds = DriveLimits(gripper=GRIPPER, force=force, speed=speed)
    effort, velocity = bounds.at(position)
    assert effort * velocity == pytest.approx(force * speed)
    h = 1e-6
    way = GRIPPER.opening(position - h) - GRIPPER.opening(position + h)
    assert effort == pytest.approx(force * way / (2.0 * h), rel=1e-6)


@given(positions)
def test_what_is_left_out_does_not_bound(position: float) -> None:
    assert DriveLimits(gripper=GRIPPER).at(position) == (math.inf, math.inf)
    assert DriveLimits(gripper=GRIPPER, effort=3.0).at(position) == (3.0, math.inf)


@pytest.mark.parametrize("force", [0.0, 19.9, 235.1, -50.0, math.nan, math.inf])
def test_a_force_that_the_gripper_lacks_is_refused(force: float) -> None:
    with pytest.raises(ControlError, match=r"force .* N is outside \[20\.0, 235\.0\]"):
        DriveLimits(gripper=GRIPPER, force=force)


@pytest.mark.parametrize("speed", [0.0, 0.019, 0.151, -0.1, math.nan, math.inf])
def test_a_speed_that_the_gripper_lacks_is_refused(speed: float) -> None:
    with pytest.raises(ControlError, match=r"speed .* m/s is outside \[0\.02, 0\.15\]"):
        DriveLimits(gripper=GRIPPER, speed=speed)


@pytest.mark.parametrize("effort", [0.0, -1.0, math.nan, math.inf])
def test_an_absurd_effort_is_refused(effort: float) -> None:
    with pytest.raises(ControlError, match="effort must be above 0 and finite"):
        DriveLimits(gripper=GRIPPER, effort=effort)


def test_a_force_and_an_effort_are_not_both_taken() -> None:
    with pytest.raises(ControlError, match=r"force \(50 N\) or an effort \(2 N·m\)"):
        DriveLimits(gripper=GRIPPER, force=50, effort=2)
