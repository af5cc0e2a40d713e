"""Masses for servos and for the governor of speeds: ``masses.c``."""

from __future__ import annotations

import ctypes

import numpy as np

from tool0.hardware.robot_hardware import RobotHardware
from tool0.kernel.memory import Addresses, FloatArray, address


def refresh_masses(
    compiled: ctypes.CDLL, robots: Addresses, hardware: RobotHardware
) -> None:
    """Compute the masses of the servos that are due in these robots.

    ``hardware`` has the drives of one of them; all have the same, with the same
    payloads.
    """
    matrices, positions = _mass_matrices(compiled, robots, hardware)
    masses, fastest = map(
        np.ascontiguousarray, hardware.servo_masses(matrices, positions.tolist())
    )
    compiled.tool0_set_masses_many(
        address(robots), len(robots), address(masses), address(fastest)
    )


def refresh_mobilities(
    compiled: ctypes.CDLL, robots: Addresses, hardware: RobotHardware
) -> None:
    """Compute the mobilities that are due, as ``refresh_masses``."""
    matrices, positions = _mass_matrices(compiled, robots, hardware)
    mobilities = np.ascontiguousarray(hardware.mobilities(matrices, positions.tolist()))
    compiled.tool0_set_mobilities_many(
        address(robots), len(robots), address(mobilities)
    )


def _mass_matrices(
    compiled: ctypes.CDLL, robots: Addresses, hardware: RobotHardware
) -> tuple[FloatArray, FloatArray]:
    """Return matrices, (n, n_bodies, n_bodies), and positions, (n, n_bodies)."""
    n, n_bodies = len(robots), len(hardware.table.dynamics.bodies)
    matrices = np.empty((n, n_bodies, n_bodies))
    positions = np.empty((n, n_bodies))
    compiled.tool0_masses_many(
        address(robots), n, address(matrices), address(positions)
    )
    return matrices, positions
