"""Kinematics and dynamics of an arm for an ArmMotionController.

Numbers of joints are in the order from base to flange.
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
    """A point fixed to the flange, in the base frame of UR."""

    position: Array
    """Position of the flange [m], shape (3,)."""
    rotation: Array
    """Rotation of the flange, shape (3, 3)."""
    jacobian: Array
    """Twist of the flange per joint velocity, linear above angular, shape (6, 6)."""


class ArmDynamics(NamedTuple):
    """Dynamics of an arm's joints, from base to flange."""

    masses: Array
    """The mass matrix [kg·m²], shape (6, 6)."""
    weight: Array
    """The efforts that balance gravity where the drives do not [N·m], shape (6,)."""


class ArmModel(Protocol):
    """Kinematics and dynamics of an arm."""

    def place(self, q: Array, lever: Array) -> Placement:
        """Return where the point ``lever`` of the flange is at ``q`` [rad]."""

    def dynamics(self, state: JointState) -> ArmDynamics:
        """Return the dynamics in a state of all joints."""

    def rotors(self) -> Sequence[float]:
        """Return the inertias of the rotors, which ``dynamics`` lacks [kg·m²]."""
