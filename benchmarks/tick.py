"""Measures the fraction of the engine's speed that the control stack reaches."""

from __future__ import annotations

import statistics
import time
from typing import Any

import mujoco

import tool0
from benchmarks.gazebo import ORIGINAL_STEPS
from tool0.engines.mujoco.engine import MujocoEngine
from tool0.protocol.controllers import Role

BLOCK = 500
"""Number of steps in one measurement.  The number is small, so that the arm does not
move far in raw steps, in which the efforts are constant."""
ROUNDS = 61
SETTLE = 1.0  # [s]
TARGET = (0.5, -1.1708, 1.0708, -0.9708, -1.0708, 1.0)


def speed_ratio(*, moving: bool, **options: Any) -> float:
    """Return the steps/s of a bring-up, divided by those of ``mj_step``.

    Blocks of both kinds alternate with one compiled model.  The blocks start from the
    same state, so that both kinds of blocks have the same contacts, and so that other
    programs on the machine slow down both kinds equally.  The result is the median of
    all rounds.  ``options`` are the options of ``tool0.bringup``.
    """
    with tool0.bringup(realtime=False, **options) as robot:
        robot.run(SETTLE)
        engine = robot.engine
        if not isinstance(engine, MujocoEngine):
            raise TypeError(f"this measures MuJoCo, not {engine.name}")
        if moving:
            duration = 2.0 * ROUNDS * BLOCK * engine.dt
            point = tool0.TrajectoryPoint(TARGET, (0.0,) * 6, time_from_start=duration)
            for controller in arm_controllers(robot):
                controller.follow([point])
        ratios = [_raw_seconds(engine) / _seconds(robot) for _ in range(ROUNDS)]
    return statistics.median(ratios)


def speed_against_original() -> float:
    """Return the steps/s of a robot at rest, relative to the original system.

    The simulation runs as fast as possible.  The steps/s of the original system were
    recorded on a machine without other load.  Therefore, the fastest block of tool0 is
    used.
    """
    with tool0.bringup(realtime=False) as robot:
        robot.run(SETTLE)
        seconds = min(_seconds(robot) for _ in range(ROUNDS))
    return BLOCK / seconds / ORIGINAL_STEPS


def arm_controllers(robot: tool0.Robot) -> list[tool0.ControllerHandle]:
    """Return the trajectory controllers of all arms."""
    return [
        robot.controller(status.name)
        for status in robot.controllers()
        if status.role is Role.TRAJECTORY
        and status.is_running
        and len(status.joints) == 6
    ]


def _seconds(robot: tool0.Robot) -> float:
    """Time a block of tool0's steps [s]."""
    start = time.perf_counter()
    robot.run(BLOCK * robot.engine.dt)
    return time.perf_counter() - start


def _raw_seconds(engine: MujocoEngine) -> float:
    """Time ``mj_step`` alone, and restore the state."""
    model, data = engine.model, engine.data
    state = data.qpos.copy(), data.qvel.copy(), data.qacc_warmstart.copy()
    start = time.perf_counter()
    for _ in range(BLOCK):
        mujoco.mj_step(model, data)
    elapsed = time.perf_counter() - start
    data.qpos[:], data.qvel[:], data.qacc_warmstart[:] = state
    return elapsed


if __name__ == "__main__":
    for is_moving in (False, True):
        name = "moving" if is_moving else "holding"
        print(f"steps/s ÷ raw mj_step, {name}: {speed_ratio(moving=is_moving):.3f}")
    print(f"steps/s ÷ the original's: {speed_against_original():.1f}")
