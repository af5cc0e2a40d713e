"""The wrench at the wrist of a robot that runs in another process."""

from __future__ import annotations

from typing import Any, Final, final

from tool0.description.transform import Vector3
from tool0.interfaces.socket.requests import Call
from tool0.sensing.wrench import WrenchReading

_PATIENCE: Final = 0.5
"""Longest wait for a sample in one request [wall s]."""


@final
class RemoteForceTorque:
    """The sensor there, with the verbs of ``robot.force_torque`` in this process."""

    def __init__(self, call: Call) -> None:
        self._call = call

    def start(self, rate: float | None = None, cutoff: float | None = None) -> float:
        """Begin to sample anew, and return at what rate [Hz]."""
        return float(self._call("wrench.start", rate=rate, cutoff=cutoff)["rate"])

    def stop(self) -> None:
        """Sample no more."""
        self._call("wrench.stop")

    def zero(self) -> None:
        """Call what is felt now zero."""
        self._call("wrench.zero")

    def read(self) -> WrenchReading:
        """Return the newest sample."""
        return _reading(self._call("wrench.read"))

    def samples(self, since: int, timeout: float = _PATIENCE) -> list[WrenchReading]:
        """Return the samples after the one with number ``since``, oldest first.

        At most 500 of them; waits ``timeout`` wall seconds for the first, and at most
        one.
        """
        answer = self._call("wrench.samples", since=since, timeout=timeout)
        return [_reading(row) for row in answer["samples"]]


def _reading(row: dict[str, Any]) -> WrenchReading:  # of JSON
    vectors = ("force", "torque", "raw_force", "raw_torque")
    return WrenchReading(**{**row, **{key: _three(row[key]) for key in vectors}})


def _three(values: list[float]) -> Vector3:
    x, y, z = values
    return x, y, z
