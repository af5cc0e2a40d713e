"""An error inside MuJoCo is a fault, as in Python: it does not end the process."""

from __future__ import annotations

from typing import Any

import mujoco
import pytest
from promised import require_kernel

import tool0
from tool0.description.model import RobotModel
from tool0.description.shapes import Box
from tool0.engines.mujoco import engine
from tool0.kernel import library

CUBE = Box(size=(0.1, 0.1, 0.1))


def test_too_little_memory_is_a_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    require_kernel()
    build_spec = engine.build_spec

    def with_little_memory(model: RobotModel, **options: Any) -> mujoco.MjSpec:
        spec = build_spec(model, **options)
        spec.memory = 100_000  # for a few contacts
        return spec

    monkeypatch.setattr(engine, "build_spec", with_little_memory)
    faults = []
    for choice in ("", "python"):
        monkeypatch.setenv(library.VARIABLE, choice)
        with tool0.bringup(gripper=None, realtime=False) as robot:
            for k in range(16):  # they fall side by side, and land together
                at = (0.8 + 0.15 * (k % 4), -0.2 + 0.15 * (k // 4), 0.1)
                robot.scene.add(f"cube{k}", CUBE, xyz=at, mass=0.1)
            with pytest.raises(mujoco.FatalError) as error:
                robot.run(2.0)
            assert robot.snapshot.fault is not None
            faults.append((robot.time, str(error.value).partition(" at ")[0]))
            robot.reset()
            robot.run(0.05)
            assert robot.snapshot.fault is None
    assert faults[0] == faults[1]
