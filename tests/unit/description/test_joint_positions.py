from __future__ import annotations

import math

import pytest

from tool0.description.forward_kinematics import joint_positions
from tool0.description.model import RobotModel
from tool0.errors import LimitsError, ModelError

OTHERWISE = [0.1, 0.2, 0.05, 9.9]  # the last one mimics: 0.2 - 0.5 · bend


def test_joints_that_are_not_given_stay_and_mimic_joints_follow(
    skew_model: RobotModel,
) -> None:
    assert joint_positions(skew_model, {}, OTHERWISE) == [0.1, 0.2, 0.05, 0.1]
    moved = joint_positions(skew_model, {"bend": 1.0}, OTHERWISE)
    assert moved == pytest.approx([0.1, 1.0, 0.05, -0.3])


def test_the_limits_themselves_are_allowed(skew_model: RobotModel) -> None:
    assert joint_positions(skew_model, {"lift": 2.8}, OTHERWISE)[0] == 2.8
    assert joint_positions(skew_model, {"lift": -2.8}, OTHERWISE)[0] == -2.8


@pytest.mark.parametrize("value", [2.9, -2.9, math.inf, math.nan])
def test_a_position_outside_the_limits_is_refused(
    skew_model: RobotModel, value: float
) -> None:
    with pytest.raises(LimitsError) as error:
        joint_positions(skew_model, {"lift": value}, OTHERWISE)
    assert "'lift'" in str(error.value)
    assert "[-2.8, 2.8]" in str(error.value)


@pytest.mark.parametrize(
    ("joint", "names"),
    [("lfit", "'lift'"), ("cap_joint", "'cap_joint'"), ("follower", "'bend'")],
    ids=["unknown", "fixed", "mimic"],
)
def test_a_joint_that_cannot_be_placed_is_refused(
    skew_model: RobotModel, joint: str, names: str
) -> None:
    with pytest.raises(ModelError) as error:
        joint_positions(skew_model, {joint: 0.0}, OTHERWISE)
    assert names in str(error.value)
