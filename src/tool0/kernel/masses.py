"""Masses and mobilities of robots' drives in the kernel (``masses.c``)."""

from __future__ import annotations

import ctypes

import numpy as np

from tool0.hardware.robot_hardware import RobotHardware
from tool0.kernel.memory import Addresses, FloatArray, address


def refresh_masses(
    compiled: ctypes.CDLL, robots: Addresses, hardware: RobotHardware
) -> None:
    """Compute the servo masses of the robots for which new masses are due.

    ``hardware`` contains the drives of one of the robots.  All robots must have the
    same drives and payloads.
    """
    robots = np.ascontiguousarray(robots)
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
    """Compute the mobilities of free joints for robots for which they are due.

    ``hardware`` has the same meaning as for ``refresh_masses``, but different brakes
    can be engaged on each robot.
    """
    robots = np.ascontiguousarray(robots)
    matrices, positions = _mass_matrices(compiled, robots, hardware)
    free = np.empty(positions.shape, dtype=np.int32)
    compiled.tool0_free_many(address(robots), len(robots), address(free))
    for joints in np.unique(free, axis=0):
        rows = (free == joints).all(axis=1).nonzero()[0]
        chosen = np.ascontiguousarray(robots[rows])
        mobilities = np.ascontiguousarray(
            hardware.mobilities(
                joints[joints >= 0].tolist(), matrices[rows], positions[rows].tolist()
            )
        )
        compiled.tool0_set_mobility_many(
            address(chosen), len(rows), address(mobilities)
        )


def _mass_matrices(
    compiled: ctypes.CDLL, robots: Addresses, hardware: RobotHardware
) -> tuple[FloatArray, FloatArray]:
    """Return mass matrices, (n, n_bodies, n_bodies), and positions, (n, n_bodies)."""
    n, n_bodies = len(robots), len(hardware.table.dynamics.bodies)
    matrices, positions = np.empty((n, n_bodies, n_bodies)), np.empty((n, n_bodies))
    compiled.tool0_masses_many(
        address(robots), n, address(matrices), address(positions)
    )
    return matrices, positions
