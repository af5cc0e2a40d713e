"""Requests about the replay of a recording: ``tool0 replay`` alone answers them.

``Pause``, ``Resume``, ``Step`` and ``SetSpeed`` apply to a replay, too; ``Reset`` goes
to its start.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

from tool0.protocol.request import Name, Request

Time = Annotated[float, Meta(ge=0.0, le=1e9)]
"""Simulated [s]."""


class SeekReplay(Request[None], frozen=True):
    """Show the recording's last snapshot up to a simulated time; outside, its ends."""

    time: Time


class LoopReplay(Request[None], frozen=True):
    """Start again at the end of the recording, or stop there."""

    loops: bool


class ReplaySamples(Struct, frozen=True, kw_only=True):
    """Samples of several signals at common times."""

    times: list[float]
    """Ascending simulated times [s]."""
    values: list[list[float | None]]
    """Values of each signal in SI units, in the order of the request; null where it has
    none.

    Of many samples these are the least and the greatest of equal intervals."""


class ReadReplay(Request[ReplaySamples], frozen=True):
    """Signals of the recording, by the names in ``view.replay.signals``."""

    signals: Annotated[tuple[Name, ...], Meta(max_length=64)]
    start: Time = 0.0
    end: Time = 1e9
    points: Annotated[int, Meta(ge=2, le=1_000_000)] = 2000
    """Approximate largest number of samples of each signal."""
