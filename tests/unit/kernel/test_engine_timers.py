"""The kernel steps MuJoCo without its timers; steps of others keep theirs."""

from __future__ import annotations

import mujoco
from promised import require_kernel

import tool0
from tool0.engines.mujoco.engine import MujocoEngine

STEP = mujoco.mjtTimer.mjTIMER_STEP


def test_only_the_kernel_does_without_timers() -> None:
    require_kernel()
    with tool0.Batch(1) as batch:
        batch.step(2)
        (engine,) = (core.engine for core in batch._cores)
        assert isinstance(engine, MujocoEngine)
        own = engine.data.timer[STEP]
        before = own.duration, own.number
        batch.step(500)
        assert own.number == before[1] + 500
        assert own.duration == before[0]
        other = mujoco.MjData(engine.model)
        mujoco.mj_step(engine.model, other, 500)
        assert other.timer[STEP].number == 500
        assert other.timer[STEP].duration > 0.0
