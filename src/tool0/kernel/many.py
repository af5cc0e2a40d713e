"""Many copies of a robot, executed by the kernel: ``many.c``."""

from __future__ import annotations

import ctypes
import weakref
from collections.abc import Sequence
from enum import IntEnum
from typing import final

import numpy as np

from tool0.hardware.robot_hardware import RobotHardware
from tool0.kernel.memory import Addresses, FloatArray, IntArray, address
from tool0.kernel.program import REFRESHES, Ended


class StartResult(IntEnum):
    """Whether motions have started."""

    YES = 0
    UNKNOWN = 1
    """No: Python knows more of the present motion than the kernel."""
    REFUSED = 2
    """No: the motion is implausible."""


@final
class BatchKernel:
    """Runs robots that are loaded into the kernel, by the addresses of their structs.

    Every array has one row per robot.
    """

    def __init__(self, compiled: ctypes.CDLL, threads: int) -> None:
        """Run ticks in so many threads, which end with this object."""
        self._compiled = compiled
        compiled.tool0_open_pool.restype = ctypes.c_void_p
        pool = compiled.tool0_open_pool(threads)
        if pool is None:
            raise MemoryError
        self._pool = ctypes.c_void_p(pool)
        weakref.finalize(self, compiled.tool0_close_pool, self._pool)

    def run(self, robots: Addresses, most: IntArray) -> tuple[IntArray, IntArray]:
        """Execute up to ``most`` ticks of each; return how many, and ``Ended``."""
        n = len(robots)
        robots, most = np.ascontiguousarray(robots), np.ascontiguousarray(most)
        done, results = np.zeros((2, n), dtype=np.int32)
        self._compiled.tool0_run_many(
            self._pool,
            address(robots),
            n,
            address(most),
            address(done),
            address(results),
        )
        return done, results

    def refresh(self, due: Ended, robots: Addresses, hardware: RobotHardware) -> None:
        """Compute what is due in these robots, as ``masses`` does."""
        REFRESHES[due](self._compiled, robots, hardware)

    def start(
        self,
        robots: Addresses,
        laws: Addresses,
        joints: Sequence[int],
        *,
        now: FloatArray,
        times: FloatArray,
        positions: FloatArray,
        velocities: FloatArray | None,
    ) -> tuple[StartResult, int]:
        """Start motions through points, as ``JointTrajectoryController.command``.

        Args:
            robots: Those that the laws move.
            laws: Those of trajectory controllers.
            joints: Which k of their joints move, by number.
            now: The time of the next tick [s], shape (n,).
            times: Of the points after now [s], increasing, shape (n, m).
            positions: Of the points [rad | m], shape (n, m, k).
            velocities: [rad/s | m/s], shape (n, m, k); None makes linear motions.

        Returns:
            Whether they started, all or none; if not, because of which row.
        """
        columns = np.array(joints, dtype=np.int32)
        arrays = [np.ascontiguousarray(a) for a in (now, times, positions)]
        speeds = None if velocities is None else np.ascontiguousarray(velocities)
        robots, laws = map(np.ascontiguousarray, (robots, laws))
        which = ctypes.c_int32(-1)
        result = self._compiled.tool0_start_many(
            address(robots),
            address(laws),
            len(laws),
            len(columns),
            address(columns),
            times.shape[1],
            *map(address, arrays),
            None if speeds is None else address(speeds),
            ctypes.byref(which),
        )
        return StartResult(result), which.value

    def desired(
        self, laws: Addresses, joint: int, now: FloatArray
    ) -> FloatArray | None:
        """Return the desired positions of one joint [rad | m], shape (n,).

        None if the kernel does not know one.
        """
        laws, now = np.ascontiguousarray(laws), np.ascontiguousarray(now)
        found = np.zeros(len(laws))
        result = self._compiled.tool0_desired_many(
            address(laws), len(laws), joint, address(now), address(found)
        )
        return found if result == StartResult.YES else None
