"""How handles reach the robot: in this process, or over a socket."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, TypeVar, final

from tool0.errors import ControlError
from tool0.protocol.goals import Goal, GoalStarted
from tool0.protocol.request import Request, checked
from tool0.protocol.state import SNAPSHOT_PERIOD
from tool0.requests.table import answer
from tool0.runtime.loop import POLL_PERIOD

if TYPE_CHECKING:
    from tool0.description.robot import RobotDescription
    from tool0.protocol.state import Snapshot
    from tool0.runtime.bus import Subscription
    from tool0.runtime.simulation import Simulation

R = TypeVar("R")


class Channel(Protocol):
    """A connection to a simulation."""

    @property
    def description(self) -> RobotDescription: ...

    @property
    def snapshot(self) -> Snapshot:
        """The newest state."""

    def call(self, request: Request[R]) -> R:
        """Return the response, or raise what the handler raised."""

    def goal(self, started: GoalStarted) -> Goal:
        """Return a goal that a request of this channel has just started."""

    def wait_until(self, is_over: Callable[[], bool], timeout: float | None) -> bool:
        """Let time pass until ``is_over()``; return False on a timeout.

        Args:
            is_over: Polled repeatedly.
            timeout: [s] of simulated time where the caller makes time pass, otherwise
                of wall time; None waits without limit.

        Raises:
            EngineError: If the physics failed.
            ControlError: If the simulation was closed or is paused without real time.
            TransportError: If the other process has ended.
        """

    def wait_for_goal(self, goal: Goal, timeout: float | None) -> bool:
        """Let time pass until ``goal`` ends, as ``wait_until`` does."""

    def subscribe(
        self, rate: float | None = None, *, keep_all: bool = False
    ) -> Subscription:
        """Return a reader of snapshots and events at ``rate`` [Hz].

        With ``keep_all`` it keeps every snapshot that arrives until it is taken.
        """

    def close(self) -> None:
        """End the simulation, or the connection to it."""


@final
class LocalChannel:
    """A connection to a simulation in this process."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._process = simulation.bus.process

    @property
    def simulation(self) -> Simulation:
        """The simulation; ControlError in a forked child, which does not own it."""
        self._process.check()
        return self._simulation

    @property
    def description(self) -> RobotDescription:
        return self.simulation.description

    @property
    def snapshot(self) -> Snapshot:
        return self.simulation.snapshot

    def call(self, request: Request[R]) -> R:
        return answer(self.simulation, checked(request))

    def goal(self, started: GoalStarted) -> Goal:
        return self.simulation.goals.find(started.goal)

    def wait_until(self, is_over: Callable[[], bool], timeout: float | None) -> bool:
        loop, bus = self.simulation.loop, self.simulation.bus
        limit = math.inf if timeout is None else timeout
        start, wall_start = loop.steps, time.monotonic()
        while not is_over():
            loop.check()
            if loop.is_closed:
                raise ControlError("the simulation was closed")
            if loop.is_realtime:
                left = limit - (time.monotonic() - wall_start)
            else:
                left = limit - (loop.steps - start) * loop.control_period
            if not left > 0.0:
                return False
            if loop.is_realtime:
                bus.newer_than(bus.latest, min(POLL_PERIOD, left))
            else:
                # Less than half a tick would round to none, and the wait would not end.
                loop.run(max(loop.control_period, min(SNAPSHOT_PERIOD, left)))
        return True

    def wait_for_goal(self, goal: Goal, timeout: float | None) -> bool:
        return self.simulation.loop.wait_for_goal(goal, timeout)

    def subscribe(
        self, rate: float | None = None, *, keep_all: bool = False
    ) -> Subscription:
        return self.simulation.subscribe(rate, keep_all=keep_all)

    def close(self) -> None:
        if self._process.is_this:  # a forked child leaves it to its parent
            self._simulation.close()
