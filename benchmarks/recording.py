"""Measures the processor time and the size of a recording with a moving robot."""

from __future__ import annotations

import statistics
import time
from itertools import cycle
from pathlib import Path
from tempfile import TemporaryDirectory

import tool0

SECONDS = 4.0
ROUNDS = 5


def recording_cost() -> tuple[float, float]:
    """Return the processor time [s] and bytes of a recording, per simulated second.

    The processor time is that of the whole process in real time.  The processor time
    includes the thread of the recorder and the additional work of the tick.  Rounds
    with a recording and rounds without a recording alternate.
    """
    differences, rates = [], []
    targets = cycle((1.0, 1.8))
    with (
        tool0.bringup(scene="table_and_cubes") as robot,
        TemporaryDirectory() as folder,
    ):
        for number in range(ROUNDS):
            without = _cpu_share(robot, next(targets))
            file = Path(folder, f"{number}.mcap")
            start = robot.start_recording(file).size
            recorded = _cpu_share(robot, next(targets))
            status = robot.stop_recording()
            differences.append(recorded - without)
            rates.append((status.size - start) / status.duration)
    return statistics.median(differences), statistics.median(rates)


def _cpu_share(robot: tool0.Robot, target: float) -> float:
    """Return the processor time per wall time while the arm moves."""
    robot.move_joints({"elbow_joint": target, "shoulder_pan_joint": target}, speed=0.1)
    cpu, wall = time.process_time(), time.monotonic()
    time.sleep(SECONDS)
    return (time.process_time() - cpu) / (time.monotonic() - wall)


if __name__ == "__main__":
    share, rate = recording_cost()
    print(f"recording: {100 * share:.1f} % of a core (at most 5)")
    print(f"recording: {rate / 1000:.0f} kB/s (at most 300)")
