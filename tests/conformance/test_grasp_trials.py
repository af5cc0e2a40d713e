"""What is gripped stays between the pads: lifted, held, and shaken at 2 g."""

from __future__ import annotations

import pytest
from benchmarks.grasping import SHAKEN, Shape, hold_and_shake, trials

HELD, MOVED = 1e-4, 5e-3
"""Slip at most, in 5 s of holding and in 3 s of shaking [m]."""
TRIALS = [
    pytest.param(
        shape,
        mass,
        id=name,
        marks=() if name == "80 mm cube, 0.5 kg" else pytest.mark.slow,
    )
    for name, shape, mass in trials()
]


@pytest.mark.parametrize(("shape", "mass"), TRIALS)
def test_what_is_gripped_is_lifted_held_and_shaken(
    engine: str, shape: Shape, mass: float
) -> None:
    held = hold_and_shake(engine, shape, mass)
    assert held.failure is None
    assert held.acceleration >= SHAKEN
    assert held.slip <= HELD
    assert held.shaken <= MOVED
