"""Computes mass matrices and gravity loads of a robot in many poses in one call.

``bodies.JointDynamics`` computes the same quantities for one pose in the tick.  In this
module, each joint is processed once for all poses.  For a thousand poses of an arm, the
computation takes a few milliseconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tool0.description.bodies import STANDARD_GRAVITY, Matrix, MovingBody
from tool0.description.joint_tree import JointTree
from tool0.description.model import JointType
from tool0.description.transform import Vector3


class SampledDynamics(NamedTuple):
    """The dynamics in ``n`` poses of ``m`` joints."""

    masses: Matrix
    """Mass matrices without the rotors' inertia [kg·m² | kg], shape (n, m, m)."""
    loads: Matrix
    """Efforts that balance gravity [N·m | N], shape (n, m)."""


def sample_dynamics(
    bodies: Sequence[MovingBody],
    positions: Matrix,
    gravity: Vector3 = STANDARD_GRAVITY,
) -> SampledDynamics:
    """Return the dynamics at ``positions`` [rad | m], shape (n_poses, n_joints).

    Mimic joints are not supported.  ``gravity`` [m/s²] is in the axes of the root.
    """
    n, m = positions.shape
    masses, loads = np.zeros((n, m, m)), np.zeros((n, m))
    frames = JointTree([body.tree_joint for body in bodies]).forward(positions)
    rotations, origins, axes = frames
    for k, body in enumerate(bodies):
        inertia = body.inertia
        center = origins[:, k] + rotations[k] @ inertia.center
        tensor = rotations[k] @ inertia.tensor @ rotations[k].transpose(0, 2, 1)
        linear, angular = np.zeros((n, m, 3)), np.zeros((n, m, 3))
        joint = k
        while joint >= 0:  # motion of the body per unit of joint velocity
            if bodies[joint].joint.type is JointType.PRISMATIC:
                linear[:, joint] = axes[:, joint]
            else:
                linear[:, joint] = np.cross(axes[:, joint], center - origins[:, joint])
                angular[:, joint] = axes[:, joint]
            joint = bodies[joint].parent
        masses += inertia.mass * linear @ linear.transpose(0, 2, 1)
        masses += angular @ tensor @ angular.transpose(0, 2, 1)
        loads -= inertia.mass * linear @ np.asarray(gravity)
    return SampledDynamics(masses, loads)
