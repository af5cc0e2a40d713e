"""The recordings of the original system, replayed: the same arm, the same outcomes."""

from __future__ import annotations

import json

import pytest
from benchmarks.golden import DATA, SCENARIOS, compare

ALLOWED = 0.003  # [rad]; 2.6 mrad were measured


def recorded_statuses(name: str) -> tuple[str, ...]:
    """Return the terminal states that the original's action client saw, in order."""
    events = json.loads((DATA / f"{name}.json").read_text())["events"]
    terminal = [
        event["event"].rsplit("status=", 1)[1]
        for event in events
        if "comm=7 " in event["event"]  # DONE
    ]
    return tuple(terminal)


def test_there_are_recordings() -> None:
    assert len(SCENARIOS) == 6


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_replay_stays_with_the_recording_and_ends_as_it_did(name: str) -> None:
    comparison = compare(name)
    assert comparison.simulated.shape == comparison.recorded.shape
    assert comparison.worst <= ALLOWED
    assert comparison.statuses == recorded_statuses(name)
