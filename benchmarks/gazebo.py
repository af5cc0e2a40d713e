"""Measures the cost of lock-step with Gazebo, and the speed of the original system."""

from __future__ import annotations

import os
import statistics
import struct
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import tool0
from benchmarks import process
from tool0.engines.gazebo.engine import GazeboEngine
from tool0.installation.gazebo.plugin import require_compiler

ORIGINAL_STEPS = 3650.0
"""Step rate of the original system, unthrottled, with the arm pointing up [1/s].  The
recordings' README gives a real-time factor of 3.5 to 3.8 with steps of 1 ms."""
ORIGINAL_START = 3.63
"""Time from the launch of the original system until three controllers run [s].  The
value is from the README of the recordings."""
BLOCK = 500
"""Number of steps in one measurement."""
ROUNDS = 31
SETTLE = 0.5  # [s]
STARTS = 5
TARGET = (0.5, -1.1708, 1.0708, -0.9708, -1.0708, 1.0)
HOLD = 1000
"""Type of the request that native_hold.cc answers instead of the bridge."""
STIFFNESS = (4000.0, 10000.0, 2000.0, 500.0, 500.0, 10.0, 10.0)  # [N·m/rad]
DAMPING = (200.0, 200.0, 20.0, 1.0, 1.0, 0.1, 0.1)  # [N·m·s/rad]
"""Stiffness and damping of the arm's six joints and the finger, from the controllers in
the post."""


@dataclass(frozen=True)
class Steps:
    """Wall times of a step [s].

    The times are medians of blocks that alternate in one world.
    """

    native: float
    """Wall time of a step whose efforts are computed in C++ [s]."""
    exchange: float
    """Additional wall time if efforts are sent and the state is received in Python
    [s]."""
    lock_step: float
    """Additional wall time of the whole tick, with controllers, drives and snapshots
    [s]."""
    holding: float
    """Wall time of the whole tick while the arm holds its position [s]."""
    moving: float
    """Wall time of the whole tick while the arm follows a trajectory [s]."""


def steps() -> Steps:
    """Measure the times of the different kinds of steps."""
    with _preloaded(), tool0.bringup(engine="gazebo", realtime=False) as robot:
        rounds = [_round(robot) for _ in range(ROUNDS)]
        _settle(robot)
        duration = 1.5 * ROUNDS * BLOCK * robot.engine.dt
        points = [tool0.TrajectoryPoint(TARGET, (0.0,) * 6, time_from_start=duration)]
        robot.controller("eff_joint_traj_controller").follow(points)
        moving = [_whole(robot) for _ in range(ROUNDS)]
    return Steps(
        native=statistics.median(native for native, _, _ in rounds),
        exchange=statistics.median(bare - native for native, bare, _ in rounds),
        lock_step=statistics.median(whole - native for native, _, whole in rounds),
        holding=statistics.median(whole for _, _, whole in rounds),
        moving=statistics.median(moving),
    )


def start_seconds() -> float:
    """Return the time from process start until the end of a bring-up [s].

    The process ends as soon as all controllers run.
    """
    command = [*process.BRINGUP, "--engine", "gazebo"]
    process.cost(command)  # compiles the plugin
    return statistics.median(process.cost(command).seconds for _ in range(STARTS))


def _round(robot: tool0.Robot) -> tuple[float, float, float]:
    """Time a step in C++, a step with the bare exchange, and a whole tick [s]."""
    engine = robot.engine
    if not isinstance(engine, GazeboEngine):
        raise TypeError(f"this measures Gazebo, not {engine.name}")
    _settle(robot)
    whole = _whole(robot)
    state = engine.read()
    native = _native(engine, state.position, state.effort)
    return native, _exchange(engine, state.effort), whole


def _settle(robot: tool0.Robot) -> None:
    """Restart, because the bare exchange advances the engine's clock."""
    robot.reset()
    robot.run(SETTLE)


def _whole(robot: tool0.Robot) -> float:
    start = time.perf_counter()
    robot.run(BLOCK * robot.engine.dt)
    return (time.perf_counter() - start) / BLOCK


def _exchange(engine: GazeboEngine, effort: list[float]) -> float:
    """Apply constant efforts that hold the pose.

    Without control, the efforts hold the pose for half a second.
    """
    start = time.perf_counter()
    for _ in range(BLOCK):
        engine.write(effort)
        engine.step()
        engine.read()
    return (time.perf_counter() - start) / BLOCK


def _native(engine: GazeboEngine, position: list[float], effort: list[float]) -> float:
    undriven = [0.0] * (len(position) - len(STIFFNESS))
    gains = [*STIFFNESS, *undriven], [*DAMPING, *undriven]
    joints = [
        struct.pack("=4d", *row) for row in zip(effort, position, *gains, strict=True)
    ]
    head = struct.pack("=3I", HOLD, BLOCK, len(joints))
    engine._connection.send(head + b"".join(joints))
    seconds: float = struct.unpack("=d", engine._connection.receive())[0]
    return seconds / BLOCK


@contextmanager
def _preloaded() -> Iterator[None]:
    """Compile native_hold.cc, and preload it into programs started meanwhile."""
    source = Path(__file__).with_name("native_hold.cc")
    before = os.environ.get("LD_PRELOAD", "")
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "native_hold.so"
        flags = ("-O2", "-fPIC", "-shared", "-std=c++17")
        command = [*require_compiler(), *flags, str(source), "-o", str(library)]
        subprocess.run([*command, "-ldl"], check=True)
        os.environ["LD_PRELOAD"] = ":".join(filter(None, (str(library), before)))
        try:
            yield
        finally:
            os.environ["LD_PRELOAD"] = before
