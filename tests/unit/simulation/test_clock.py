from __future__ import annotations

import pytest
from manual_clock import ManualClock

from tool0.simulation.clock import CATCH_UP, SLOW_WINDOWS, Lag, Pacer, SpeedMeter


def ticks_until_caught_up(pacer: Pacer) -> int:
    n_ticks = 0
    while pacer.wait_time() <= 0.0:
        pacer.tick()
        n_ticks += 1
    return n_ticks


@pytest.mark.parametrize("speed", [0.5, 1.0, 4.0])
def test_ticks_are_due_a_period_apart_at_the_speed(speed: float) -> None:
    wall = ManualClock()
    pacer = Pacer(0.01, speed, wall)
    assert pacer.wait_time() == 0.0
    for n_ticks in range(1, 50):
        pacer.tick()
        expected = n_ticks * 0.01 / speed - (wall.time - 100.0)
        assert pacer.wait_time() == pytest.approx(expected, abs=1e-12)
        wall.time += pacer.wait_time()
    assert pacer.overruns == 0


def test_waiting_too_long_does_not_make_later_ticks_late() -> None:
    wall = ManualClock()
    pacer = Pacer(0.001, now=wall)
    for _ in range(1000):
        pacer.tick()
        wall.time += pacer.wait_time() + 0.0004  # a sleep always lasts a little longer
    assert wall.time - 100.0 == pytest.approx(1.0004)
    assert pacer.overruns == 0


def test_what_was_missed_is_caught_up_and_counted() -> None:
    wall = ManualClock()
    pacer = Pacer(0.001, now=wall)
    wall.time += 0.0505  # 50 ticks and a half
    assert ticks_until_caught_up(pacer) == 51
    assert pacer.overruns == 50  # the last one was half a period late


def test_what_was_missed_beyond_the_catch_up_is_given_up() -> None:
    wall = ManualClock()
    pacer = Pacer(0.001, now=wall)
    wall.time += 3600.0
    n_ticks = ticks_until_caught_up(pacer)
    assert n_ticks == pytest.approx(CATCH_UP / 0.001, abs=2)


def test_the_speed_meter_measures_over_its_window() -> None:
    wall = ManualClock()
    meter = SpeedMeter(wall)
    assert not meter.measure(0.3)
    wall.time += 0.5
    assert not meter.measure(1.0)
    assert meter.factor == 0.0
    wall.time += 0.5
    assert meter.measure(2.5)
    assert meter.factor == pytest.approx(2.5)
    wall.time += 0.5
    assert not meter.measure(0.0)  # a reset
    wall.time += 1.0
    assert meter.measure(1.0)
    assert meter.factor == pytest.approx(1.0)


def test_the_speed_meter_counts_the_late_ticks_of_its_window() -> None:
    wall = ManualClock()
    meter = SpeedMeter(wall)
    for overruns, late_ticks in ((40, 40), (43, 3), (43, 0)):
        wall.time += 1.0
        assert meter.measure(wall.time, overruns)
        assert meter.late_ticks == late_ticks


def test_a_pause_does_not_count_as_slow() -> None:
    wall = ManualClock()
    meter = SpeedMeter(wall)
    wall.time += 60.0
    meter.restart(0.0, 5)
    wall.time += 1.0
    assert meter.measure(1.0, 5)
    assert meter.factor == pytest.approx(1.0)
    assert meter.late_ticks == 0


def test_only_a_lasting_lag_is_a_change() -> None:
    lag = Lag()
    hiccups = [0.5, 1.0] * 20
    assert not any(lag.changes(share) for share in hiccups)
    slow = [lag.changes(0.6) for _ in range(100)]
    assert slow.index(True) < SLOW_WINDOWS
    assert slow.count(True) == 1
    assert lag.is_behind
    good = [lag.changes(1.0) for _ in range(100)]
    assert good.count(True) == 1
    assert not lag.is_behind
