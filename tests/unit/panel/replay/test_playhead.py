"""The time that a replay shows."""

import pytest

from tool0.panel.replay.playhead import MAX_SPEED, Playhead


class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def playhead(clock: Clock) -> Playhead:
    return Playhead(2.0, 12.0, clock)


def test_it_waits_at_the_start(playhead: Playhead, clock: Clock) -> None:
    clock.now += 5.0
    assert playhead.time == 2.0
    assert not playhead.is_playing


def test_it_plays_at_its_speed(playhead: Playhead, clock: Clock) -> None:
    playhead.play()
    clock.now += 2.0
    playhead.set_speed(0.5)
    clock.now += 4.0
    assert playhead.time == pytest.approx(6.0)
    playhead.pause()
    clock.now += 4.0
    assert playhead.time == pytest.approx(6.0)


def test_it_stops_at_the_end_and_then_plays_from_the_start(
    playhead: Playhead, clock: Clock
) -> None:
    playhead.play()
    clock.now += 11.0
    assert playhead.time == 12.0
    assert not playhead.is_playing
    playhead.play()
    clock.now += 1.0
    assert playhead.time == pytest.approx(3.0)


def test_it_loops(playhead: Playhead, clock: Clock) -> None:
    playhead.set_loops(True)
    playhead.play()
    clock.now += 23.0
    assert playhead.time == pytest.approx(5.0)
    assert playhead.is_playing


def test_it_goes_to_a_time_or_the_nearer_end(playhead: Playhead) -> None:
    for wanted, shown in ((7.0, 7.0), (0.0, 2.0), (99.0, 12.0)):
        playhead.seek(wanted)
        assert playhead.time == shown


def test_its_speed_has_bounds(playhead: Playhead) -> None:
    playhead.set_speed(1e9)
    assert playhead.speed == MAX_SPEED


def test_a_single_instant_is_no_endless_loop(clock: Clock) -> None:
    playhead = Playhead(1.0, 1.0, clock)
    playhead.set_loops(True)
    playhead.play()
    clock.now += 1.0
    assert playhead.time == 1.0
    assert not playhead.is_playing
