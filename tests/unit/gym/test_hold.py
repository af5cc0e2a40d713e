"""Where pads hold an object, and which turns fit."""

from __future__ import annotations

import numpy as np
import pytest

from tool0.gym.hold import Hold, folded

YAWS = np.linspace(-7.0, 7.0, 57)


@pytest.mark.parametrize("turns", [1, 2, 4])
def test_a_folded_angle_is_the_smallest_with_the_same_effect(turns: int) -> None:
    part = 2.0 * np.pi / turns
    found = folded(YAWS, turns)
    assert (np.abs(found) <= part / 2.0 + 1e-12).all()
    whole = (YAWS - found) / part
    np.testing.assert_allclose(whole, np.round(whole), atol=1e-12)


def test_the_place_turns_with_the_object() -> None:
    quarter = np.array([[np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]])
    hold = Hold(0.02, (0.07, 0.01, 0.005), turns=2)
    place = hold.places(np.array([[1.0, 2.0, 3.0]]), quarter)
    np.testing.assert_allclose(place, [[0.99, 2.07, 3.005]], atol=1e-12)
    turn = hold.turn(np.array([0.3]), quarter)
    assert turn == pytest.approx(np.pi / 2.0 - 0.3)
