"""How much of the engine's speed is left under the control stack."""

from __future__ import annotations

import statistics
import time

import mujoco

import tool0
from tool0.engines.mujoco.engine import MujocoEngine

BLOCK = 2000
"""Steps of one measurement."""
ROUNDS = 15
TARGET = (0.5, -1.1708, 1.0708, -0.9708, -1.0708, 1.0)


def speed_ratio(
    *,
    moving: bool,
    description: tool0.DescriptionConfig = tool0.DescriptionConfig(),
) -> float:
    """Return simulated steps/s of a bring-up, the default one, ÷ raw ``mj_step``.

    Blocks alternate, on one compiled model, from one state, so that both meet the same
    contacts and the same neighbours on the machine; the median of all rounds.
    """
    with tool0.bringup(description=description, realtime=False) as robot:
        robot.run(1.0)
        if moving:
            duration = 2.0 * ROUNDS * BLOCK * 1e-3
            points = [
                tool0.TrajectoryPoint(TARGET, (0.0,) * 6, time_from_start=duration)
            ]
            robot.controller("eff_joint_traj_controller").follow(points)
        engine = robot.engine
        if not isinstance(engine, MujocoEngine):
            raise TypeError(f"this measures MuJoCo, not {engine.name}")
        ratios = []
        for _ in range(ROUNDS):
            raw = _raw_seconds(engine)
            start = time.perf_counter()
            robot.run(BLOCK * engine.dt)
            ratios.append(raw / (time.perf_counter() - start))
    return statistics.median(ratios)


def _raw_seconds(engine: MujocoEngine) -> float:
    """Time ``mj_step`` alone, and put the state back."""
    model, data = engine.model, engine.data
    state = data.qpos.copy(), data.qvel.copy(), data.qacc_warmstart.copy()
    start = time.perf_counter()
    for _ in range(BLOCK):
        mujoco.mj_step(model, data)
    elapsed = time.perf_counter() - start
    data.qpos[:], data.qvel[:], data.qacc_warmstart[:] = state
    return elapsed
