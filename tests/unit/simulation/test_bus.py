from __future__ import annotations

import threading
from collections.abc import Iterable

import pytest

from tool0.protocol.bus import EVENTS_KEPT, SNAPSHOTS_KEPT, Bus, Overran, WasReset
from tool0.protocol.state import Snapshot


def snapshot(tick: int) -> Snapshot:
    return Snapshot(
        time=tick * 0.001,
        tick=tick,
        joint_names=(),
        position=(),
        velocity=(),
        effort=(),
        controllers=(),
        is_paused=False,
        is_stopped=False,
        real_time_factor=1.0,
        overruns=0,
    )


def publish(bus: Bus, ticks: Iterable[int]) -> None:
    for tick in ticks:
        bus.publish(snapshot(tick))


@pytest.fixture
def bus() -> Bus:
    return Bus()


def test_each_reader_gets_the_latest_snapshot_once(bus: Bus) -> None:
    assert bus.latest is None
    first, second = bus.subscribe(), bus.subscribe()
    assert first.next(timeout=0.0) is None
    publish(bus, range(10))
    assert first.next(timeout=0.0) == second.next() == bus.latest == snapshot(9)
    assert first.next(timeout=0.0) is None
    publish(bus, [10])
    assert first.next(timeout=0.0) == snapshot(10)


def test_a_slow_reader_may_have_one_after_the_other(bus: Bus) -> None:
    reader = bus.subscribe()
    publish(bus, [0, 1])
    assert reader.following(timeout=0.0) == snapshot(1)  # it begins with the newest
    publish(bus, range(2, 10))
    for tick in range(2, 10):
        assert reader.following(timeout=0.0) == snapshot(tick)
    assert reader.following(timeout=0.0) is None


def test_a_reader_that_falls_far_behind_goes_on_with_the_oldest_there_is(
    bus: Bus,
) -> None:
    reader = bus.subscribe()
    publish(bus, [0])
    reader.following(timeout=0.0)
    publish(bus, range(1, SNAPSHOTS_KEPT + 11))
    assert reader.following(timeout=0.0) == snapshot(11)
    assert reader.next(timeout=0.0) == snapshot(SNAPSHOTS_KEPT + 10)


def test_a_reader_that_waits_is_woken(bus: Bus) -> None:
    reader = bus.subscribe()
    got: list[Snapshot | None] = []
    thread = threading.Thread(target=lambda: got.append(reader.next(timeout=30.0)))
    thread.start()
    publish(bus, [1])
    thread.join(30.0)
    assert got == [snapshot(1)]


def test_a_reader_misses_nothing_published_before_another_one_came(bus: Bus) -> None:
    publish(bus, range(5))
    reader = bus.subscribe()
    assert reader.following(timeout=0.0) == snapshot(4)
    publish(bus, range(5, 8))
    assert reader.following(timeout=0.0) == snapshot(5)
    later = bus.subscribe()
    assert later.pending() == [snapshot(7)]
    assert reader.pending() == [snapshot(6), snapshot(7)]
    reader.close()
    later.close()
    publish(bus, [8, 9])
    assert reader.following(timeout=0.0) == snapshot(9)  # none is kept for nobody
    assert later.pending() == [snapshot(9)]


def test_the_newest_events_are_kept_in_order_until_they_are_read(bus: Bus) -> None:
    bus.announce(WasReset())  # nobody listens yet
    reader = bus.subscribe()
    events = [Overran(n, 0.1 * n) for n in range(EVENTS_KEPT + 10)]
    for event in events[:5]:
        bus.announce(event)
    publish(bus, range(3))
    assert list(reader.events) == events[:5]
    for event in events[5:]:
        bus.announce(event)
    assert list(reader.events) == events[10:]


def test_a_closed_subscription_hears_nothing_more(bus: Bus) -> None:
    reader, other = bus.subscribe(), bus.subscribe()
    reader.close()
    reader.close()
    bus.announce(WasReset())
    assert not reader.events
    assert list(other.events) == [WasReset()]


def test_the_history_reaches_half_a_second_back_however_much_is_published(
    bus: Bus,
) -> None:
    publish(bus, (tick for tick in range(2000) for _ in range(3)))
    ticks = [item.tick for item in bus.history()]
    assert ticks == [*range(1488, 2000, 8), 1999]
    publish(bus, [0, 1])  # a reset
    assert [item.tick for item in bus.history()][-2:] == [0, 1]
