"""A payload replaces the tool of the description in the model of the drives."""

from __future__ import annotations

import numpy as np
import pytest

from tool0.description.bodies import JointDynamics
from tool0.description.loading import assemble
from tool0.description.model import RobotModel
from tool0.description.payload import Payload
from tool0.description.payload_bodies import modelled_payload, replaced_tools

POSE = (0.3, -1.2, 0.9, -0.5, 1.1, 0.4)
GRAVITY = 9.81


@pytest.fixture(scope="module")
def bare() -> RobotModel:
    return assemble("ur5", "none").model


@pytest.fixture(scope="module")
def gripping() -> RobotModel:
    return assemble("ur5", "2f85").model


def dynamics(model: RobotModel, payload: Payload | None) -> JointDynamics:
    payloads = {} if payload is None else {"tool0": payload}
    return JointDynamics(model, added=replaced_tools(model, payloads))


def pose_of(model: RobotModel) -> list[float]:
    return [*POSE, *[0.0] * (len(model.movable_joints) - len(POSE))]


def test_the_modelled_payload_changes_no_load(gripping: RobotModel) -> None:
    payload, q = modelled_payload(gripping, "tool0"), pose_of(gripping)
    loads = dynamics(gripping, payload).static_effort(q)
    expected = JointDynamics(gripping).static_effort(q)
    np.testing.assert_allclose(loads, expected, atol=1e-9)


def test_two_tools_with_one_payload_load_the_arm_alike(
    bare: RobotModel, gripping: RobotModel
) -> None:
    payload = Payload(2.0, (0.01, -0.02, 0.12))
    alone = dynamics(bare, payload)
    q = pose_of(gripping)
    both = dynamics(gripping, payload)
    np.testing.assert_allclose(
        both.static_effort(q)[:6], alone.static_effort(POSE), atol=1e-9
    )
    np.testing.assert_allclose(
        both.mass_matrix(q)[:6, :6], alone.mass_matrix(POSE), atol=1e-9
    )


@pytest.mark.parametrize("mass", [0.0, 0.4, 5.0])
def test_the_load_is_the_derivative_of_the_weights_height(
    bare: RobotModel, mass: float
) -> None:
    center = (0.05, 0.02, 0.1)
    with_it = dynamics(bare, Payload(mass, center)).static_effort(POSE)
    without = dynamics(bare, None).static_effort(POSE)
    added = np.subtract(with_it, without)

    def height(q: np.ndarray) -> float:
        from tool0.description.forward_kinematics import link_pose

        names = [joint.name for joint in bare.movable_joints]
        pose = link_pose(bare, dict(zip(names, q, strict=True)), "tool0")
        return pose.apply(center)[2]

    step = 1e-6
    for k in range(6):
        shift = np.eye(6)[k] * step
        q = np.array(POSE)
        slope = (height(q + shift) - height(q - shift)) / (2 * step)
        assert added[k] == pytest.approx(mass * GRAVITY * slope, abs=1e-5)
