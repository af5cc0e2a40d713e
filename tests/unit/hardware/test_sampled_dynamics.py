"""Many poses at once have the dynamics that each has alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tool0.description.bodies import JointDynamics, moving_bodies
from tool0.description.loading import assemble
from tool0.description.model import (
    Inertial,
    Joint,
    JointType,
    Link,
    RobotModel,
)
from tool0.description.transform import Pose
from tool0.hardware.sampled_dynamics import sample_dynamics


def sliding_arm() -> RobotModel:
    """Return a rail with two arms on its carriage: a tree with a prismatic joint."""
    mass = Inertial(
        mass=2.0, origin=Pose(xyz=(0.1, 0.2, 0.3)), ixx=0.1, iyy=0.12, izz=0.09
    )
    names = ("carriage", "left", "right")
    kinds = (JointType.PRISMATIC, JointType.REVOLUTE, JointType.REVOLUTE)
    axes = ((1.0, 0.0, 0.0), (0.0, 0.6, 0.8), (0.0, 0.0, -1.0))
    return RobotModel(
        name="sliding",
        root="base",
        links=(Link(name="base"), *(Link(name=n, inertial=mass) for n in names)),
        joints=tuple(
            Joint(
                name=f"{name}_joint",
                type=kind,
                parent="base" if name == "carriage" else "carriage",
                child=name,
                origin=Pose(xyz=(0.0, 0.3, 0.1), rpy=(0.2, -0.4, 1.0)),
                axis=axis,
            )
            for name, kind, axis in zip(names, kinds, axes, strict=True)
        ),
    )


@pytest.mark.parametrize("gravity", [(0.0, 0.0, -9.81), (3.0, -4.0, 5.0)])
@pytest.mark.parametrize("model", [assemble(gripper=None).model, sliding_arm()])
def test_it_is_what_one_pose_at_a_time_gives(
    model: RobotModel, gravity: tuple[float, float, float]
) -> None:
    bodies = moving_bodies(model)
    rng = np.random.default_rng(seed=0)
    positions = rng.uniform(-math.pi, math.pi, size=(20, len(bodies)))
    found = sample_dynamics(bodies, positions, gravity)
    alone = JointDynamics(model, gravity)
    for row, masses, loads in zip(positions.tolist(), *found, strict=True):
        np.testing.assert_allclose(masses, alone.mass_matrix(row), atol=1e-12)
        np.testing.assert_allclose(loads, alone.static_effort(row), atol=1e-12)
