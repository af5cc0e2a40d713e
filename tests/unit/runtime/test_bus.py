from __future__ import annotations

import threading

from tool0.runtime.bus import EVENTS_KEPT, SNAPSHOTS_KEPT, Bus, Overran, WasReset
from tool0.sensing.snapshot import Snapshot


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


def test_a_new_bus_has_nothing_to_tell() -> None:
    bus = Bus()
    assert bus.latest is None
    assert bus.subscribe().next(timeout=0.0) is None


def test_a_slow_reader_skips_to_the_latest() -> None:
    bus = Bus()
    reader = bus.subscribe()
    for tick in range(10):
        bus.publish(snapshot(tick))
    assert reader.next(timeout=0.0) == snapshot(9)
    assert bus.latest == snapshot(9)


def test_a_reader_sees_no_snapshot_twice() -> None:
    bus = Bus()
    reader = bus.subscribe()
    bus.publish(snapshot(1))
    assert reader.next() is not None
    assert reader.next(timeout=0.0) is None
    bus.publish(snapshot(2))
    assert reader.next(timeout=0.0) == snapshot(2)


def test_a_slow_reader_may_have_one_after_the_other() -> None:
    bus = Bus()
    reader = bus.subscribe()
    bus.publish(snapshot(0))
    bus.publish(snapshot(1))
    assert reader.following(timeout=0.0) == snapshot(1)  # it begins with the newest
    for tick in range(2, 10):
        bus.publish(snapshot(tick))
    for tick in range(2, 10):
        assert reader.following(timeout=0.0) == snapshot(tick)
    assert reader.following(timeout=0.0) is None


def test_a_reader_that_falls_far_behind_goes_on_with_the_oldest_there_is() -> None:
    bus = Bus()
    reader = bus.subscribe()
    bus.publish(snapshot(0))
    reader.following(timeout=0.0)
    for tick in range(1, SNAPSHOTS_KEPT + 11):
        bus.publish(snapshot(tick))
    assert reader.following(timeout=0.0) == snapshot(11)
    assert reader.next(timeout=0.0) == snapshot(SNAPSHOTS_KEPT + 10)


def test_readers_do_not_disturb_each_other() -> None:
    bus = Bus()
    first, second = bus.subscribe(), bus.subscribe()
    bus.publish(snapshot(1))
    assert first.next(timeout=0.0) == second.next(timeout=0.0) == snapshot(1)


def test_a_reader_that_waits_is_woken() -> None:
    bus = Bus()
    reader = bus.subscribe()
    got: list[Snapshot | None] = []
    thread = threading.Thread(target=lambda: got.append(reader.next(timeout=30.0)))
    thread.start()
    bus.publish(snapshot(1))
    thread.join(30.0)
    assert got == [snapshot(1)]


def test_events_are_kept_in_order_until_they_are_read() -> None:
    bus = Bus()
    bus.announce(WasReset())  # nobody listens yet
    reader = bus.subscribe()
    events = [Overran(n, 0.1 * n) for n in range(5)]
    for event in events:
        bus.announce(event)
    for tick in range(3):
        bus.publish(snapshot(tick))
    assert list(reader.events) == events


def test_a_reader_that_never_reads_costs_bounded_memory() -> None:
    bus = Bus()
    reader = bus.subscribe()
    for n in range(EVENTS_KEPT + 10):
        bus.announce(Overran(n, 0.0))
    assert len(reader.events) == EVENTS_KEPT
    assert reader.events[-1] == Overran(EVENTS_KEPT + 9, 0.0)


def test_a_closed_subscription_hears_nothing_more() -> None:
    bus = Bus()
    reader, other = bus.subscribe(), bus.subscribe()
    reader.close()
    reader.close()
    bus.announce(WasReset())
    assert not reader.events
    assert list(other.events) == [WasReset()]


def test_the_history_reaches_half_a_second_back_however_much_is_published() -> None:
    bus = Bus()
    for tick in range(2000):
        for _ in range(3):
            bus.publish(snapshot(tick))
    ticks = [item.tick for item in bus.history()]
    assert ticks == [*range(1488, 2000, 8), 1999]
    bus.publish(snapshot(0))  # a reset
    bus.publish(snapshot(1))
    assert [item.tick for item in bus.history()][-2:] == [0, 1]
