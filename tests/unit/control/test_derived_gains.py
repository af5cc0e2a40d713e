"""Laws of the gains that follow from the model."""

from __future__ import annotations

import math

import numpy as np
import pytest
import yaml

from tool0.control.default_controllers import PERIOD
from tool0.control.gains import (
    DRIVE_SHARE,
    INTEGRAL_RATE,
    SAMPLING,
    DerivedGains,
    derive_arm_gains,
    derive_gripper_gains,
)
from tool0.description.bodies import JointDynamics
from tool0.description.catalogue import find_part
from tool0.description.loading import assemble
from tool0.description.model import RobotModel

JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
PAYLOAD = 5.0


@pytest.fixture(scope="module")
def model() -> RobotModel:
    return assemble("ur5", None).model


@pytest.fixture(scope="module")
def gains(model: RobotModel) -> tuple[DerivedGains, ...]:
    return derive_arm_gains(model, JOINTS, PAYLOAD, period=PERIOD)


def test_sampled_damping_is_stable_in_random_postures(
    model: RobotModel, gains: tuple[DerivedGains, ...]
) -> None:
    dynamics = JointDynamics(model)
    root = np.sqrt([item.d for item in gains])
    rng = np.random.default_rng(seed=0)
    for q in rng.uniform(-math.pi, math.pi, size=(300, 6)).tolist():
        inverse = np.linalg.inv(dynamics.mass_matrix(q))
        values = np.linalg.eigvalsh(root[:, None] * inverse * root)
        assert values.max() * PERIOD < 1.01 * SAMPLING


def test_a_longer_period_has_less_damping_and_stiffness(
    model: RobotModel, gains: tuple[DerivedGains, ...]
) -> None:
    slow = derive_arm_gains(model, JOINTS, PAYLOAD, period=2 * PERIOD)
    for item, slower in zip(gains, slow, strict=True):
        assert slower.d <= item.d / 2 * 1.01 or slower.d == pytest.approx(item.d)
        assert slower.p <= item.p


def test_a_payload_needs_stiffness_and_not_less_damping(
    model: RobotModel, gains: tuple[DerivedGains, ...]
) -> None:
    light = derive_arm_gains(model, JOINTS, None, period=PERIOD)
    for item, without in zip(gains[1:3], light[1:3], strict=True):
        assert item.p > without.p
        assert item.i_clamp > without.i_clamp
        assert item.acceleration <= without.acceleration
    assert "with 5 kg" in gains[0].derivation
    assert "without payload" in light[0].derivation


def test_a_gripper_counts_as_part_of_the_payload() -> None:
    with_gripper = assemble("ur5", "2f85").model
    light = derive_arm_gains(with_gripper, JOINTS, 0.5, period=PERIOD)
    none = derive_arm_gains(with_gripper, JOINTS, 0.0, period=PERIOD)
    assert [item.p for item in light] == [item.p for item in none]


def test_drives_can_hold_and_accelerate_the_arm(
    model: RobotModel, gains: tuple[DerivedGains, ...]
) -> None:
    for joint, item in zip(JOINTS, gains, strict=True):
        limits = model.joint(joint).limits
        assert 0.0 < item.i_clamp <= limits.effort
        assert 0.0 < item.i <= INTEGRAL_RATE * item.p * 1.01
        assert 0.0 < item.acceleration <= model.joint(joint).max_acceleration * 1.01
        assert item.jerk > 0.0
    stretched = JointDynamics(model)
    left = 150.0 - abs(stretched.static_effort([0.0] * 6)[1])
    needed = stretched.mass_matrix([0.0] * 6)[1] * [i.acceleration for i in gains]
    assert np.linalg.norm(needed) < DRIVE_SHARE * left


def test_they_are_near_the_published_ones(gains: tuple[DerivedGains, ...]) -> None:
    file = find_part("arm", "ur5").file("gains.yaml")
    published = yaml.safe_load(file.read_text(encoding="utf-8"))["gains"]
    for joint, item in zip(JOINTS, gains, strict=True):
        assert 1 / 5 < item.p / published[joint]["p"] < 5
        assert 1 / 2 < item.d / published[joint]["d"] < 2


def test_a_base_on_a_wall_changes_the_loads_alone(
    gains: tuple[DerivedGains, ...],
) -> None:
    turned = assemble("ur5", None, base_rpy=(0.0, math.pi / 2, 0.0)).model
    wall = derive_arm_gains(turned, JOINTS, PAYLOAD, period=PERIOD)
    assert [item.d for item in wall] == [item.d for item in gains]
    assert wall[0].i_clamp > 4 * gains[0].i_clamp  # the pan joint carries the arm


@pytest.mark.parametrize(
    ("gripper", "joint"), [("2f85", "finger_joint"), ("hande", "")]
)
def test_a_gripper_is_critically_damped(gripper: str, joint: str) -> None:
    model = assemble("ur5", gripper).model
    joint = joint or model.grippers[0].joint
    item = derive_gripper_gains(model, joint, period=PERIOD)
    names = [each.name for each in model.movable_joints]
    middle = [0.0] * len(names)
    index = names.index(joint)
    middle[index] = model.joint(joint).limits.upper / 2
    inertia = JointDynamics(model).mass_matrix(middle)[index, index]
    assert item.d / (2 * math.sqrt(item.p * inertia)) == pytest.approx(1.0, abs=0.05)
    assert item.i == 0.0
