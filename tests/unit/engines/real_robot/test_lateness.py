"""How long before its start a motion is sent, by how late packages are."""

from __future__ import annotations

import random

import pytest

from tool0.engines.real_robot.lateness import MARGIN, MEMORY, MOST, Lateness

PERIOD = 0.008


def arrivals(
    lateness: Lateness, start: float, duration: float, late: float, ahead: float = 100.0
) -> float:
    """Let packages arrive, each late by up to ``late`` [s]; return the time after."""
    chance, now = random.Random(0), start
    while now < start + duration:
        now += PERIOD
        lateness.observe(now, now + ahead + chance.uniform(0.0, late))
    return now


def test_it_is_the_margin_and_twice_the_latest_package() -> None:
    lateness = Lateness()
    arrivals(lateness, 5.0, 4.0, 0.0)
    assert lateness.start_delay == pytest.approx(MARGIN, abs=1e-3)
    arrivals(lateness, 9.0, 4.0, 0.04)
    assert lateness.start_delay == pytest.approx(MARGIN + 0.08, abs=5e-3)


def test_late_packages_are_forgotten_and_no_delay_is_longer_than_the_knots() -> None:
    lateness = Lateness()
    now = arrivals(lateness, 0.0, 4.0, 0.5)
    assert lateness.start_delay == MOST
    arrivals(lateness, now, 2.0 * MEMORY + 1.0, 0.01)
    assert lateness.start_delay == pytest.approx(MARGIN + 0.02, abs=3e-3)


def test_a_clock_that_was_set_is_not_late() -> None:
    lateness = Lateness()
    now = arrivals(lateness, 0.0, 2.0, 0.0)
    arrivals(lateness, now, 2.0, 0.0, ahead=-3600.0)
    assert lateness.start_delay == pytest.approx(MARGIN, abs=1e-3)
