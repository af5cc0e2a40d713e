"""How much of the engine's speed is left for the copies of a batch."""

from __future__ import annotations

import statistics
import time
from dataclasses import dataclass

import mujoco
import numpy as np

import tool0

N_COPIES = 256
THREADS = 2
TICKS = 50
"""Of one measurement: an action at 20 Hz."""
ROUNDS = 9


@dataclass(frozen=True)
class BatchCost:
    """Steps of all copies, beside those of the engine alone."""

    ratio: float
    """Steps/s ÷ (threads × raw steps/s of one thread)."""
    with_actions: float
    """The same with commands to arms and grippers and all arrays read, each round."""
    bytes_per_copy: float


def cost(n: int = N_COPIES, threads: int = THREADS) -> BatchCost:
    """Return the cost of copies that move arm and gripper to new targets all the time.

    Raw steps and those of the batch alternate, on the same models and states; the
    medians of all rounds.
    """
    before = _resident()
    with tool0.Batch(n, threads=threads) as batch:
        engines = batch._engines  # the compiled models, and their states
        columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
        home = batch.position[:, columns]
        rng = np.random.default_rng(0)
        batch.step(10)
        grown = _resident() - before
        ratios, with_actions = [], []
        for _ in range(ROUNDS):
            raw = _raw_seconds([(e.model, e.data) for e in engines])
            start = time.perf_counter()
            batch.command(home + rng.uniform(-0.1, 0.1, home.shape), duration=0.05)
            batch.move_gripper(rng.uniform(0.0, 0.08, n))
            commanded = time.perf_counter()
            batch.step(TICKS)
            stepped = time.perf_counter()
            batch.position, batch.velocity, batch.tool_pose(), batch.tcp_pose()  # noqa: B018
            read = time.perf_counter()
            ratios.append(raw / threads / (stepped - commanded))
            with_actions.append(raw / threads / (read - start))
    return BatchCost(
        statistics.median(ratios), statistics.median(with_actions), grown / n
    )


def _raw_seconds(copies: list[tuple[mujoco.MjModel, mujoco.MjData]]) -> float:
    """Time ``mj_step`` alone in one thread, and put the states back."""
    states = [
        (d.qpos.copy(), d.qvel.copy(), d.qacc_warmstart.copy()) for _, d in copies
    ]
    start = time.perf_counter()
    for model, data in copies:
        for _ in range(TICKS):
            mujoco.mj_step(model, data)
    elapsed = time.perf_counter() - start
    for (_, data), state in zip(copies, states, strict=True):
        data.qpos[:], data.qvel[:], data.qacc_warmstart[:] = state
        data.time -= TICKS * 1e-3
    return elapsed


def _resident() -> float:
    """Return the resident memory of this process [B]."""
    with open("/proc/self/statm", encoding="ascii") as file:  # noqa: PTH123
        return float(file.read().split()[1]) * 4096.0


if __name__ == "__main__":
    print(cost())
