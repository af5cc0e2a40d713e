"""The filter: what passes, what does not, and how it begins."""

from __future__ import annotations

import math

import pytest

from tool0.errors import ControlError
from tool0.sensing.low_pass import LowPass


def amplitude(frequency: float, cutoff: float, rate: float = 1000.0) -> float:
    """Return what passes of a wave of amplitude one, once it has settled."""
    low_pass = LowPass(cutoff, rate)
    n = round(rate * (5.0 / cutoff + 2.0 / frequency))
    waves = [math.sin(2.0 * math.pi * frequency * k / rate) for k in range(n)]
    passed = [low_pass([wave])[0] for wave in waves]
    return max(map(abs, passed[-math.ceil(rate / frequency) :]))


def test_it_passes_what_is_slow_and_stops_what_is_fast() -> None:
    assert amplitude(1.0, 20.0) == pytest.approx(1.0, abs=0.01)
    assert amplitude(20.0, 20.0) == pytest.approx(math.sqrt(0.5), abs=0.01)
    assert amplitude(200.0, 20.0) == pytest.approx(0.0075, abs=0.002)


def test_what_was_there_at_the_start_was_there_always() -> None:
    low_pass = LowPass(15.0, 125.0)
    for _ in range(50):
        assert low_pass([3.0, -2.0]) == pytest.approx([3.0, -2.0])


def test_a_ramp_is_late_by_what_is_said() -> None:
    low_pass = LowPass(15.0, 1000.0)
    passed = [low_pass([0.001 * k])[0] for k in range(1000)]
    assert 0.999 - passed[-1] == pytest.approx(0.225 / 15.0, rel=0.01)


@pytest.mark.parametrize("cutoff", [0.0, 62.5, math.nan, -1.0])
def test_a_cutoff_out_of_range_is_refused(cutoff: float) -> None:
    with pytest.raises(ControlError):
        LowPass(cutoff, 125.0)
