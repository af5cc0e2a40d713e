"""Detection of freezes with clocks that the tests advance."""

from __future__ import annotations

import pytest
from manual_clock import ManualClock

from tool0.protocol.freeze_meter import Activity, FreezeMeter


@pytest.fixture
def wall() -> ManualClock:
    return ManualClock()


@pytest.fixture
def processor() -> ManualClock:
    return ManualClock()


@pytest.fixture
def activity(wall: ManualClock, processor: ManualClock) -> Activity:
    return Activity(wall, processor)


def test_a_process_that_did_not_run_was_frozen(
    wall: ManualClock, processor: ManualClock, activity: Activity
) -> None:
    meter = FreezeMeter(activity)
    for _ in range(100):
        wall.time += 0.01
        processor.time += 0.005
        assert meter.look() == 0.0
    wall.time += 2.5
    assert meter.look() == pytest.approx(2.5)
    assert meter.look() == 0.0


@pytest.mark.parametrize(("late", "used"), [(0.9, 0.0), (3.0, 2.0)])
def test_a_late_or_busy_process_was_not_frozen(
    late: float,
    used: float,
    wall: ManualClock,
    processor: ManualClock,
    activity: Activity,
) -> None:
    meter = FreezeMeter(activity)
    wall.time += late
    processor.time += used
    assert meter.look() == 0.0


def test_every_meter_reports_a_freeze_once(
    wall: ManualClock, activity: Activity
) -> None:
    meters = [FreezeMeter(activity), FreezeMeter(activity)]
    wall.time += 1.5
    assert [meter.look() for meter in meters] == [1.5, 1.5]
    wall.time += 0.5
    assert [meter.look() for meter in meters] == [0.0, 0.0]


def test_a_process_with_one_delayed_thread_was_not_frozen(
    wall: ManualClock, activity: Activity
) -> None:
    punctual, delayed = FreezeMeter(activity), FreezeMeter(activity)
    for _ in range(30):
        wall.time += 0.1
        assert punctual.look() == 0.0
    assert delayed.look() == 0.0


def test_a_freeze_before_the_meter_exists_is_not_reported(
    wall: ManualClock, activity: Activity
) -> None:
    wall.time += 5.0
    assert FreezeMeter(activity).look() == 0.0


def test_the_processor_time_of_a_parent_process_does_not_count(
    wall: ManualClock, processor: ManualClock, activity: Activity
) -> None:
    processor.time = 0.0  # of the forked process
    wall.time += 0.01
    meter = FreezeMeter(activity)
    wall.time += 2.0
    processor.time += 1.9
    assert meter.look() == 0.0
