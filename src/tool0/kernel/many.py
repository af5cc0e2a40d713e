"""Execution of many copies of a robot by the kernel (``many.c``)."""

from __future__ import annotations

import ctypes
import weakref
from enum import IntEnum
from typing import final

import numpy as np

from tool0.hardware.robot_hardware import RobotHardware
from tool0.kernel.memory import (
    Addresses,
    BoolArray,
    FloatArray,
    IntArray,
    TickCounts,
    address,
)
from tool0.kernel.program import REFRESHES, Ended


class StartResult(IntEnum):
    """Result of a request to start motions."""

    YES = 0
    UNKNOWN = 1
    """The motions have not started, because only Python has all data of the current
    motion."""
    REFUSED = 2
    """The motions have not started, because a motion is implausible."""


_STARTS = tuple(StartResult)  # indexing takes a tenth of the time of StartResult(...)


@final
class BatchKernel:
    """Runner of robots in the kernel; the robots are given by their addresses.

    Every array has one row per robot.  The addresses are those of the robots' structs.
    """

    def __init__(
        self,
        compiled: ctypes.CDLL,
        threads: int,
        *,
        left: TickCounts,
        ticks: TickCounts,
        untold: TickCounts,
    ) -> None:
        """Start a pool of threads, which is stopped when this object is deleted.

        Args:
            compiled: The kernel.
            threads: Number of threads.
            left: Numbers of ticks to execute.  A run subtracts the executed ticks.
            ticks: Counters to which a run adds the executed ticks.
            untold: Additional counters to which a run adds the executed ticks.
        """
        n = len(left)
        self._compiled = compiled
        self.robots: Addresses = np.zeros(n, dtype=np.uintp)
        """Addresses of the robots' structs; 0 for robots that are not loaded."""
        self.most: IntArray = np.zeros(n, dtype=np.int32)
        """Largest number of ticks that each robot executes in one run."""
        self.results: IntArray = np.zeros(n, dtype=np.int32)
        """Reason why each robot's last run ended, as a value of ``Ended``."""
        compiled.tool0_open_pool.restype = ctypes.c_void_p
        pool = compiled.tool0_open_pool(threads)
        if pool is None:
            raise MemoryError
        self._pool = ctypes.c_void_p(pool)
        weakref.finalize(self, compiled.tool0_close_pool, self._pool)
        self._robots, self._most = address(self.robots), address(self.most)
        counts = address(left), address(ticks), address(untold)
        self._counts = *counts, address(self.results)
        self._read = compiled.tool0_read_many
        self._read.restype = None

    def run(self) -> bool:
        """Execute up to ``most`` remaining ticks of each loaded robot.

        Return whether an event ended the run of a robot, or whether ticks are left.
        """
        n = len(self.robots)
        return bool(
            self._compiled.tool0_run_many(
                self._pool, self._robots, n, self._most, *self._counts
            )
        )

    def refresh(self, hardware: RobotHardware) -> None:
        """Compute the masses and mobilities that are due; set results to ``DONE``.

        ``hardware`` is the hardware of one of the robots.
        """
        for due, compute in REFRESHES.items():
            if (is_due := self.results == due).any():
                compute(self._compiled, self.robots[is_due], hardware)
                self.results[is_due] = Ended.DONE

    def read(self, which: BoolArray, n_joints: int) -> FloatArray:
        """Return positions, velocities and efforts of robots, shape (3, n, n_joints).

        Where ``which``, shape (n,), is false, the values are undefined.
        """
        n = len(which)
        found = np.empty((3, n, n_joints))
        self._read(self._robots, n, n_joints, address(which), address(found))
        return found

    def start(
        self,
        robots: Addresses,
        laws: Addresses,
        joints: IntArray,
        *,
        now: FloatArray,
        times: FloatArray,
        positions: FloatArray,
        velocities: FloatArray | None,
    ) -> tuple[StartResult, int]:
        """Start motions through points, as ``JointTrajectoryController.command`` does.

        Args:
            robots: Addresses of the robots that the laws move.
            laws: Addresses of the laws of trajectory controllers.
            joints: Numbers of the k joints of each law that move, shape (k,).
            now: The time of the next tick [s], shape (n,).
            times: Times of the points relative to ``now`` [s], in increasing order,
                shape (n, m).
            positions: Positions of the points [rad | m], shape (n, m, k).
            velocities: Velocities at the points [rad/s | m/s], shape (n, m, k).  If
                ``velocities`` is None, the motions between the points are linear.

        Returns:
            Whether all motions have started, and the row that prevented the start.  If
            not all motions can start, no motion is started.
        """
        arrays = [np.ascontiguousarray(a) for a in (now, times, positions)]
        speeds = None if velocities is None else np.ascontiguousarray(velocities)
        robots, laws = map(np.ascontiguousarray, (robots, laws))
        which = ctypes.c_int32(-1)
        result = self._compiled.tool0_start_many(
            address(robots),
            address(laws),
            len(laws),
            len(joints),
            address(joints),
            times.shape[1],
            *map(address, arrays),
            None if speeds is None else address(speeds),
            ctypes.byref(which),
        )
        return _STARTS[result], which.value

    def desired(
        self, laws: Addresses, joint: int, now: FloatArray
    ) -> FloatArray | None:
        """Return the desired positions of one joint [rad | m], shape (n,).

        The method returns None if the kernel does not have all desired positions.
        """
        laws, now = np.ascontiguousarray(laws), np.ascontiguousarray(now)
        found = np.zeros(len(laws))
        result = self._compiled.tool0_desired_many(
            address(laws), len(laws), joint, address(now), address(found)
        )
        return found if result == StartResult.YES else None
