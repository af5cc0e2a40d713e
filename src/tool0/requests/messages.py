"""Messages that every connection can receive, besides replies and snapshots."""

from __future__ import annotations

from typing import Literal

from msgspec import Struct

from tool0.requests.codec import Outcome

Mode = Literal["simulation", "view"]


class Hello(Struct, frozen=True, kw_only=True, tag="hello"):
    """The first message of the server."""

    protocol: int
    version: str
    """Of tool0."""
    name: str
    """Of the bring-up."""
    pid: int
    mode: Mode
    """``view`` is a robot without physics and controllers."""


class GoalEnded(Struct, frozen=True, kw_only=True, tag="goal_finished"):
    """A goal ended: to the connection that started it, and to subscribers."""

    goal: int | None
    """Its number; null for a goal that no request started."""
    controller: str
    outcome: Outcome


class Fault(Struct, frozen=True, kw_only=True, tag="fault"):
    """The physics or a controller failed: the simulation waits for a reset."""

    message: str
    time: float
    """Simulated [s]."""


class ResetDone(Struct, frozen=True, kw_only=True, tag="reset"):
    """Robot and objects are where they started."""

    time: float
    """Simulated time, which may have continued [s]."""


class LateTicks(Struct, frozen=True, kw_only=True, tag="overrun"):
    """Ticks began late within the last second of wall time."""

    count: int
    time: float
    """Simulated [s]."""


EventMessage = GoalEnded | Fault | ResetDone | LateTicks
