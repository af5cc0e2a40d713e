"""Masses of servos, for robots that the kernel executes: ``masses.c``."""

from __future__ import annotations

import ctypes

import numpy as np

from tool0.hardware.robot_hardware import RobotHardware
from tool0.kernel.memory import Addresses, address


def refresh_masses(
    compiled: ctypes.CDLL, robots: Addresses, hardware: RobotHardware
) -> None:
    """Compute the masses of the servos that are due in these robots.

    ``hardware`` has the drives of one of them; all have the same, with the same
    payloads.
    """
    n, n_bodies = len(robots), len(hardware.table.dynamics.bodies)
    matrices = np.empty((n, n_bodies, n_bodies))
    positions = np.empty((n, n_bodies))
    robots = np.ascontiguousarray(robots)
    compiled.tool0_masses_many(
        address(robots), n, address(matrices), address(positions)
    )
    masses, fastest = map(
        np.ascontiguousarray, hardware.servo_masses(matrices, positions.tolist())
    )
    compiled.tool0_set_masses_many(
        address(robots), n, address(masses), address(fastest)
    )
