"""Requests about the replay of a recording: ``tool0 replay`` alone carries them out.

``Pause``, ``Resume``, ``Step`` and ``SetSpeed`` apply to a replay, too; ``Reset`` goes
to its start.
"""

from __future__ import annotations

from typing import Any

from tool0.errors import ControlError
from tool0.protocol.replay import LoopReplay, ReadReplay, SeekReplay
from tool0.requests.table import handles
from tool0.runtime.simulation import Simulation


@handles(SeekReplay)
@handles(LoopReplay)
@handles(ReadReplay)
def _only_of_a_replay(simulation: Simulation, request: Any) -> None:
    raise ControlError("this robot is running; `tool0 replay FILE` replays a recording")
