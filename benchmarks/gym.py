"""Measures the fraction of the engine's speed that learning environments reach."""

from __future__ import annotations

import statistics
import time
from dataclasses import dataclass

import gymnasium
import numpy as np

import tool0.gym  # noqa: F401  # registers the tasks
from benchmarks.batch import TICKS, raw_seconds

N_COPIES = 64
THREADS = 2
ACTIONS = 4
"""Number of actions in one measurement.  Each action takes 50 ms of simulated time."""
ROUNDS = 15


@dataclass(frozen=True)
class GymCost:
    """Speed of a vector environment's physics steps, compared with the engine alone."""

    ratio: float
    """Steps/s, divided by the number of threads times the raw steps/s of one thread."""
    same_threads: float
    """Steps/s, divided by the raw steps/s of the same number of parallel threads.  On a
    busy machine, other programs slow down both measurements."""
    processor: float
    """Steps per second of processor time, divided by the raw steps.  Other programs
    change this ratio less than the other ratios."""
    python: float
    """Fraction of a step's time that is not spent in the physics."""


def cost(task: str = "Lift", n: int = N_COPIES, threads: int = THREADS) -> GymCost:
    """Return the cost of ``n`` copies with random actions at 20 Hz.

    Raw steps and steps of the environment alternate, with the same models and states.
    The results are the medians of all rounds.
    """
    env = gymnasium.make_vec(f"tool0/{task}-v0", num_envs=n, threads=threads)
    env.reset(seed=0)
    rng = np.random.default_rng(0)
    shape = (ACTIONS, *env.action_space.shape)
    batch = env.unwrapped.copies.batch
    # the engines have the models and states
    engines = [core.engine for core in batch._cores]
    ratios, same_threads, processor, python = [], [], [], []
    for _ in range(ROUNDS):
        actions = rng.uniform(-1.0, 1.0, shape).astype(np.float32)
        copies = [(engine.model, engine.data) for engine in engines]
        before = time.process_time()
        raw = ACTIONS * raw_seconds([copies])
        raw_processor = ACTIONS * (time.process_time() - before)
        at_once = ACTIONS * raw_seconds([copies[k::threads] for k in range(threads)])
        start, before = time.perf_counter(), time.process_time()
        for action in actions:
            env.step(action)
        processor.append(raw_processor / (time.process_time() - before))
        elapsed = time.perf_counter() - start
        start = time.perf_counter()
        batch.step(ACTIONS * TICKS)
        physics = time.perf_counter() - start
        ratios.append(raw / threads / elapsed)
        same_threads.append(at_once / elapsed)
        python.append(1.0 - physics / elapsed)
    env.close()
    return GymCost(
        statistics.median(ratios),
        statistics.median(same_threads),
        statistics.median(processor),
        statistics.median(python),
    )


if __name__ == "__main__":
    print(cost())
