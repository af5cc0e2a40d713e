"""How much of the engine's speed is left for the copies of a batch."""

from __future__ import annotations

import statistics
import threading
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
    """Steps/s ÷ (threads times the raw steps/s of one thread)."""
    same_threads: float
    """Steps/s ÷ the raw steps/s of as many threads at once: what a busy machine, whose
    processors do other things too, leaves to both."""
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
        engines = [core.engine for core in batch._cores]  # their models and states
        columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
        home = batch.position[:, columns]
        rng = np.random.default_rng(0)
        batch.step(10)
        grown = _resident() - before
        ratios, same_threads, with_actions = [], [], []
        for _ in range(ROUNDS):
            copies = [(engine.model, engine.data) for engine in engines]
            raw = raw_seconds([copies])
            at_once = raw_seconds([copies[k::threads] for k in range(threads)])
            start = time.perf_counter()
            batch.command(home + rng.uniform(-0.1, 0.1, home.shape), duration=0.05)
            batch.move_gripper(rng.uniform(0.0, 0.08, n))
            commanded = time.perf_counter()
            batch.step(TICKS)
            stepped = time.perf_counter()
            batch.position, batch.velocity, batch.tool_pose(), batch.tcp_pose()
            read = time.perf_counter()
            ratios.append(raw / threads / (stepped - commanded))
            same_threads.append(at_once / (stepped - commanded))
            with_actions.append(raw / threads / (read - start))
    return BatchCost(
        statistics.median(ratios),
        statistics.median(same_threads),
        statistics.median(with_actions),
        grown / n,
    )


def raw_seconds(parts: list[list[tuple[mujoco.MjModel, mujoco.MjData]]]) -> float:
    """Time ``mj_step`` alone, each part in a thread, and put the states back."""

    def work(copies: list[tuple[mujoco.MjModel, mujoco.MjData]]) -> None:
        for model, data in copies:
            mujoco.mj_step(model, data, nstep=TICKS)

    every = [data for copies in parts for _, data in copies]
    states = [
        (d.time, d.qpos.copy(), d.qvel.copy(), d.qacc_warmstart.copy()) for d in every
    ]
    threads = [threading.Thread(target=work, args=(copies,)) for copies in parts]
    start = time.perf_counter()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    elapsed = time.perf_counter() - start
    for data, state in zip(every, states, strict=True):
        data.time, data.qpos[:], data.qvel[:], data.qacc_warmstart[:] = state
    return elapsed


def _resident() -> float:
    """Return the resident memory of this process [B]."""
    with open("/proc/self/statm", encoding="ascii") as file:  # noqa: PTH123
        return float(file.read().split()[1]) * 4096.0


if __name__ == "__main__":
    print(cost())
