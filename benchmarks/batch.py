"""Compares the speed of a batch with the engine alone and with MuJoCo's own batches."""

from __future__ import annotations

import statistics
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import mujoco
import mujoco.batch
import mujoco.rollout
import numpy as np

import tool0

N_COPIES = 256
THREADS = 2
TICKS = 50
"""Number of ticks in one measurement, which is one action at 20 Hz."""
ROUNDS = 9


@dataclass(frozen=True)
class BatchCost:
    """Speed of the steps of all copies, compared with the engine alone."""

    ratio: float
    """Steps/s, divided by the number of threads times the raw steps/s of one thread."""
    same_threads: float
    """Steps/s, divided by the raw steps/s of the same number of parallel threads.  On a
    busy machine, other programs slow down both measurements."""
    with_actions: float
    """The same as ``ratio``, but each round also includes commands to arms and
    grippers, and the reading of all arrays."""
    bytes_per_copy: float


def cost(n: int = N_COPIES, threads: int = THREADS) -> BatchCost:
    """Return the cost of copies that continuously move to new targets.

    Raw steps and steps of the batch alternate, with the same models and states.  The
    results are the medians of all rounds.
    """
    before = _resident()
    with tool0.Batch(n, threads=threads) as batch:
        # the engines have the models and states
        engines = [core.engine for core in batch._cores]
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
    """Time ``mj_step`` with one thread for each part, and restore the states."""

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


class Ratio(NamedTuple):
    """Speed divided by the speed of ``mujoco.rollout``; medians of all rounds."""

    wall: float
    """Ratio in wall time."""
    processor: float
    """Ratio in processor time, which does not include the time of other programs."""
    spread: float
    """Half the interquartile range of ``processor``."""


def compare(n: int, threads: int = THREADS, rounds: int = 41) -> Mapping[str, Ratio]:
    """Return the speed of each way to run n copies, relative to ``mujoco.rollout``.

    In each round, all ways to run the copies start from the same states, in random
    order.  Only ``tool0.Batch`` computes control laws; with the other ways, the efforts
    of the motors remain constant.
    """
    threads = min(n, threads)
    costs: dict[str, list[tuple[float, float]]] = {}
    rng = np.random.default_rng(0)
    with tool0.Batch(n, threads=threads) as copies:
        copies.step(200)
        physics = _Physics(copies, threads)
        ways = physics.ways() | {"tool0.Batch": lambda: copies.step(TICKS)}
        for _ in range(rounds):
            physics.save()
            for name in rng.permutation(list(ways)).tolist():
                physics.restore()
                wall, processor = time.perf_counter(), time.process_time()
                ways[name]()
                cost = time.perf_counter() - wall, time.process_time() - processor
                costs.setdefault(name, []).append(cost)
    rollout = costs.pop("mujoco.rollout")
    return {name: _ratio(rollout, own) for name, own in costs.items()}


def _ratio(one: list[tuple[float, float]], own: list[tuple[float, float]]) -> Ratio:
    ratios = np.array(one) / np.array(own)
    low, middle, high = np.percentile(ratios, [25, 50, 75], axis=0)
    return Ratio(float(middle[0]), float(middle[1]), float(high[1] - low[1]) / 2.0)


class _Physics:
    """The models and states of the copies, which MuJoCo's own batches step."""

    _WHOLE = mujoco.mjtState.mjSTATE_INTEGRATION
    _START = mujoco.mjtState.mjSTATE_FULLPHYSICS

    def __init__(self, copies: tool0.Batch, threads: int) -> None:
        engines = [core.engine for core in copies._cores]
        self._models = [engine.model for engine in engines]
        self._data = [engine.data for engine in engines]
        self._scratch = [mujoco.MjData(self._models[0]) for _ in range(threads)]
        self._pool = mujoco.rollout.Rollout(nthread=threads)
        self._batch = mujoco.batch.Batch(self._models[0], copies.n, threads)
        self._batch.set_models(self._models)
        self._ctrl = self._batch.bind("ctrl")
        self.save()

    def save(self) -> None:
        """Save the current states of the copies."""
        self._states = self._rows(self._WHOLE)
        self._starts = self._rows(self._START)
        self._warm = np.array([data.qacc_warmstart for data in self._data])
        self._efforts = np.array([data.ctrl for data in self._data])
        self._controls = np.repeat(self._efforts[:, None], TICKS, axis=1)

    def _rows(self, what: mujoco.mjtState) -> np.ndarray:
        rows = np.empty((len(self._data), mujoco.mj_stateSize(self._models[0], what)))
        for row, model, data in zip(rows, self._models, self._data, strict=True):
            mujoco.mj_getState(model, data, row, what)
        return rows

    def restore(self) -> None:
        """Restore the saved states in MuJoCo's batch."""
        self._batch.state[:] = self._states

    def ways(self) -> dict[str, Callable[[], None]]:
        """Return functions that step all copies."""
        return {
            "mujoco.rollout": self._roll,
            "mujoco.batch": lambda: self._batch.step(nstep=TICKS),
            "mujoco.batch, a call per step": self._single_steps,
        }

    def _roll(self) -> None:
        self._pool.rollout(
            self._models,
            self._scratch,
            self._starts,
            self._controls,
            nstep=TICKS,
            initial_warmstart=self._warm,
        )

    def _single_steps(self) -> None:
        """Set efforts before each step, as control laws outside MuJoCo require."""
        for _ in range(TICKS):
            self._ctrl[:] = self._efforts
            self._batch.step()


def _resident() -> float:
    """Return the resident memory of this process [bytes]."""
    with open("/proc/self/statm", encoding="ascii") as file:  # noqa: PTH123
        return float(file.read().split()[1]) * 4096.0


if __name__ == "__main__":
    print(cost())
    for number in (1, 16, 64):
        for name, ratio in compare(number).items():
            print(
                f"{number} copies, {name} ÷ mujoco.rollout: {ratio.wall:.2f} by wall "
                f"time, {ratio.processor:.2f} ± {ratio.spread:.2f} by processor time"
            )
