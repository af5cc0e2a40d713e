"""Kinematics and dynamics of an arm for an ArmMotionController.

The joints are indexed from the base to the flange.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol

from tool0.hardware.engine import JointState

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


class Placement(NamedTuple):
    """Pose and Jacobian of a point fixed to the flange, in UR's base frame."""

    position: Array
    """Position of the point [m], shape (3,)."""
    rotation: Array
    """Rotation of the flange, shape (3, 3)."""
    jacobian: Array
    """Jacobian at the point, with the linear rows above the angular rows, shape (6,
    6)."""


class ArmDynamics(NamedTuple):
    """Dynamics of an arm's joints, from the base to the flange."""

    masses: Array
    """Mass matrix [kg·m²], shape (6, 6)."""
    weight: Array
    """Efforts that balance gravity [N·m], shape (6,).  The efforts are 0 for drives
    that compensate gravity."""


class ArmModel(Protocol):
    """Kinematics and dynamics of an arm."""

    def place(self, q: Array, lever: Array) -> Placement:
        """Return the placement of a point at the joint positions ``q`` [rad].

        ``lever`` is the position of the point in the flange frame [m].
        """

    def dynamics(self, state: JointState) -> ArmDynamics:
        """Return the dynamics for a state of all joints."""

    def rotors(self) -> Sequence[float]:
        """Return the rotor inertias, which ``dynamics`` does not contain [kg·m²]."""
