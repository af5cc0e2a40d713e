"""Which snapshots become frames."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from tool0.cli.demos.monitor import FrameRecorder
from tool0.protocol.state import Snapshot

PERIOD = 0.008  # [s]


def snapshot(time: float) -> Snapshot:
    return Snapshot(
        time=time,
        tick=round(time / 0.001),
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


def times(film: FrameRecorder, span: Iterable[int]) -> list[float]:
    """Show it snapshots of ``span``, in periods, and return when its frames are."""
    for k in span:
        film.record(snapshot(PERIOD * k))
    return [frame.time for frame in film.frames]


def test_frames_are_as_many_as_the_rate_says_and_evenly_spread() -> None:
    found = times(FrameRecorder(rate=30), range(1251))  # 10 s
    assert len(found) == pytest.approx(300, abs=1)
    for number, time in enumerate(found):
        assert number / 30 - 1e-9 <= time < number / 30 + PERIOD


def test_time_that_nobody_watched_is_cut_and_slows_nothing_down() -> None:
    film = FrameRecorder(rate=30)
    n_before = len(times(film, range(126)))  # 1 s
    found = times(film, range(625, 751))  # 1 s, 4 s later
    assert len(found) == pytest.approx(2 * n_before, abs=1)
    assert found[n_before] == pytest.approx(5.0)


def test_after_a_reset_it_goes_on() -> None:
    film = FrameRecorder(rate=30)
    n_before = len(times(film, range(126)))
    found = times(film, range(126))
    assert len(found) == 2 * n_before
    assert found[n_before] == 0.0


def test_a_state_that_was_published_twice_is_one_frame() -> None:
    assert times(FrameRecorder(), [0, 0, 0, 1]) == [0.0]
