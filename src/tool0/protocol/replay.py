"""Requests about the replay of a recording; only ``tool0 replay`` answers them.

``Pause``, ``Resume``, ``Step`` and ``SetSpeed`` also apply to a replay; ``Reset`` seeks
to the start of the recording.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

from tool0.protocol.request import Name, Request

Time = Annotated[float, Meta(ge=0.0, le=1e9)]
"""Simulated time [s]."""


class SeekReplay(Request[None], frozen=True):
    """Show the last snapshot at or before a simulated time.

    For a time outside the recording, show the nearer end of the recording.
    """

    time: Time


class LoopReplay(Request[None], frozen=True):
    """Set whether the replay restarts or stops at the end of the recording."""

    loops: bool


class ReplaySamples(Struct, frozen=True, kw_only=True):
    """Samples of several signals at the same times."""

    times: list[float]
    """Ascending simulated times [s]."""
    values: list[list[float | None]]
    """Values of each signal in SI units, in the order of the request; null without a
    value.

    If there are too many samples, the values are the minima and maxima over equal
    intervals."""


class ReadReplay(Request[ReplaySamples], frozen=True):
    """Read signals of the recording; ``view.replay.signals`` lists all signal names."""

    signals: Annotated[tuple[Name, ...], Meta(max_length=64)]
    start: Time = 0.0
    end: Time = 1e9
    points: Annotated[int, Meta(ge=2, le=1_000_000)] = 2000
    """Approximate maximum number of samples per signal."""
