from __future__ import annotations

import math

import pytest
from tool0.runtime.initial_pose import joint_positions

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
    with pytest.raises(LimitsError, match=r"joint 'lift' is outside \[-2\.8, 2\.8\]"):
        joint_positions(skew_model, {"lift": value}, OTHERWISE)


def test_an_unknown_joint_is_refused_with_the_nearest(skew_model: RobotModel) -> None:
    with pytest.raises(ModelError, match="'lfit'; did you mean 'lift'"):
        joint_positions(skew_model, {"lfit": 0.0}, OTHERWISE)


def test_a_fixed_joint_cannot_be_placed(skew_model: RobotModel) -> None:
    with pytest.raises(ModelError, match="unknown joint 'cap_joint'"):
        joint_positions(skew_model, {"cap_joint": 0.0}, OTHERWISE)


def test_a_mimic_joint_names_its_master(skew_model: RobotModel) -> None:
    with pytest.raises(ModelError, match="'follower' mimics 'bend'; place that one"):
        joint_positions(skew_model, {"follower": 0.0}, OTHERWISE)
