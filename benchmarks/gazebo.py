"""What lock-step costs on Gazebo, and how the whole compares with the original."""

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
"""Of the original system, unthrottled, arm up [1/s].  The recordings' README tells of a
real-time factor of 3.5 to 3.8, at steps of 1 ms."""
ORIGINAL_START = 3.63
"""From its launch to three controllers running [s], from the same README."""
BLOCK = 500
"""Steps of one measurement."""
ROUNDS = 31
SETTLE = 0.5  # [s]
STARTS = 5
TARGET = (0.5, -1.1708, 1.0708, -0.9708, -1.0708, 1.0)
HOLD = 1000
"""Kind of the request that native_hold.cc answers, in the bridge's place."""
STIFFNESS = (4000.0, 10000.0, 2000.0, 500.0, 500.0, 10.0, 10.0)  # [N·m/rad]
DAMPING = (200.0, 200.0, 20.0, 1.0, 1.0, 0.1, 0.1)  # [N·m·s/rad]
"""Of the arm's six joints and the finger, as in the post's controllers."""


@dataclass(frozen=True)
class Steps:
    """Wall time of a step [s], medians of blocks that took turns in one world."""

    native: float
    """Efforts computed in C++."""
    exchange: float
    """More than that: efforts sent and the state received in Python."""
    lock_step: float
    """More than that: the whole tick, with controllers, drives and snapshots."""
    holding: float
    """All of the whole tick."""
    moving: float
    """The same, on the way of a trajectory."""


def steps() -> Steps:
    """Time the four kinds of steps."""
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
    """Return process start to all controllers running, and out [s]."""
    command = [*process.BRINGUP, "--engine", "gazebo"]
    process.cost(command)  # compiles
    return statistics.median(process.cost(command).seconds for _ in range(STARTS))


def _round(robot: tool0.Robot) -> tuple[float, float, float]:
    """Time a step in C++, of the bare exchange, and of the whole [s]."""
    engine = robot.engine
    if not isinstance(engine, GazeboEngine):
        raise TypeError(f"this measures Gazebo, not {engine.name}")
    _settle(robot)
    whole = _whole(robot)
    state = engine.read()
    native = _native(engine, state.position, state.effort)
    return native, _exchange(engine, state.effort), whole


def _settle(robot: tool0.Robot) -> None:
    """Begin anew: the bare exchange makes the engine's clock run ahead."""
    robot.reset()
    robot.run(SETTLE)


def _whole(robot: tool0.Robot) -> float:
    start = time.perf_counter()
    robot.run(BLOCK * robot.engine.dt)
    return (time.perf_counter() - start) / BLOCK


def _exchange(engine: GazeboEngine, effort: list[float]) -> float:
    """Apply what holds the pose: for half a second, it still does without control."""
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
    """Compile native_hold.cc, and have it loaded into what is started meanwhile."""
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
