"""What is gripped stays between the pads: lifted, held, and shaken at 2 g."""

from __future__ import annotations

import pytest
from benchmarks.grasping import SHAKEN, Shape, hold_and_shake, trials

from tool0.engines.registry import engine_names

HELD, MOVED = 1e-4, 5e-3
"""Slip at most, in 5 s of holding and in 3 s of shaking [m]."""
ON_GAZEBO = ("20 mm cube, 0.05 kg", "80 mm cube, 0.5 kg", "43 mm cylinder, 0.5 kg")
"""The ends of the range, and what is round: Gazebo simulates 13 s in four."""
TRIALS = [
    pytest.param(
        engine,
        shape,
        mass,
        id=f"{engine}, {name}",
        marks=() if name == "80 mm cube, 0.5 kg" else pytest.mark.slow,
    )
    for engine in engine_names()
    for name, shape, mass in trials()
    if engine != "gazebo" or name in ON_GAZEBO
]


@pytest.mark.parametrize(("engine", "shape", "mass"), TRIALS, indirect=["engine"])
def test_what_is_gripped_is_lifted_held_and_shaken(
    engine: str, shape: Shape, mass: float
) -> None:
    held = hold_and_shake(engine, shape, mass)
    assert held.failure is None
    assert held.acceleration >= SHAKEN
    assert held.slip <= HELD
    assert held.shaken <= MOVED
