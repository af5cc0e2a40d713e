"""A backend that consists of published states and a function for each request.

The backend is for robots that are not simulated: their time is wall time.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping
from typing import TYPE_CHECKING, Any, Final, final

from tool0.protocol.bus import Bus, Subscription
from tool0.protocol.controllers import ListControllers
from tool0.protocol.fork_guard import OwnProcess
from tool0.protocol.goal_registry import GoalRegistry
from tool0.protocol.goals import Goal
from tool0.protocol.request import Request
from tool0.protocol.robot import ReadDescription, ReadSnapshot
from tool0.protocol.sent_description import description_info
from tool0.protocol.state import SNAPSHOT_PERIOD, Snapshot

if TYPE_CHECKING:
    from tool0.description.robot import RobotDescription

_POLL_PERIOD: Final = 0.02
"""Longest time between two checks of a condition during a wait [wall s]."""


@final
class LiveStates:
    """States of a robot that runs in real time; see ``backend.States``."""

    def __init__(
        self, description: RobotDescription, first: Snapshot, close: Callable[[], None]
    ) -> None:
        """Create the bus, and publish the first state.

        Args:
            description: Description of the robot.
            first: Present state of the robot.
            close: Function that stops publishing states; called once.
        """
        self.description = description
        self.bus = Bus()
        """Bus on which the robot publishes its states and events."""
        self.goals = GoalRegistry()
        self.cameras: Final = None
        self._close: Callable[[], None] | None = close
        self.bus.publish(first)

    @property
    def process(self) -> OwnProcess:
        return self.bus.process

    @property
    def snapshot(self) -> Snapshot:
        snapshot = self.bus.latest
        assert snapshot is not None  # the first snapshot is published in __init__
        return snapshot

    @property
    def time(self) -> float:
        return self.snapshot.time

    def subscribe(
        self,
        rate: float | None = None,
        *,
        keep_all: bool = False,
        with_commands: bool = False,
        with_arms: bool = False,
        with_contacts: bool = False,
        latest_only: bool = False,
        when_published: Callable[[], None] | None = None,
    ) -> Subscription:
        return self.bus.subscribe(
            SNAPSHOT_PERIOD if rate is None else 1.0 / rate,
            keep_all=keep_all,
            with_commands=with_commands,
            with_arms=with_arms,
            with_contacts=with_contacts,
            latest_only=latest_only,
            when_published=when_published,
        )

    def refresh(self) -> None:
        """Do nothing, because states are published without requests."""

    def snapshot_with_arms(self) -> Snapshot:
        return self.snapshot

    def wait_until(self, is_over: Callable[[], bool], timeout: float | None) -> bool:
        end = None if timeout is None else time.monotonic() + timeout
        while not is_over():
            if end is not None and time.monotonic() >= end:
                return False
            self.bus.newer_than(self.bus.latest, _POLL_PERIOD)
        return True

    def wait_for_goal(self, goal: Goal, timeout: float | None) -> bool:
        return self.wait_until(lambda: goal.status.is_terminal, timeout)

    def close(self) -> None:
        close, self._close = self._close, None
        if close is not None:
            close()


@final
class LiveBackend:
    """Answers requests by calling functions directly; see ``backend.Backend``."""

    mode: Final = "simulation"

    def __init__(
        self,
        states: LiveStates,
        handlers: Mapping[type[Request[Any]], Callable[[Any], Any]],
        reason: str,
    ) -> None:
        """Offer the requests that have a handler.

        Args:
            states: States of the robot.
            handlers: Request class → function that answers it.  Requests for the
                description and the newest state already have handlers.
            reason: Reason why other requests are not offered, such as ``this robot has
                no objects``.
        """
        self.states = states
        self._handlers: dict[type[Request[Any]], Callable[[Any], Any]] = {
            ReadDescription: lambda _: description_info(states.description, 0.0),
            ReadSnapshot: lambda _: states.snapshot,
            ListControllers: lambda _: states.snapshot.controllers,
            **handlers,
        }
        self._reason = reason

    def why_missing(self, request: type[Request[Any]]) -> str:
        return "" if request in self._handlers else self._reason

    def answer(self, request: Request[Any]) -> Any:
        return self._handlers[type(request)](request)

    def post(
        self, request: Request[Any], when_failed: Callable[[Exception], None]
    ) -> None:
        self.answer(request)

    def check_setpoint(self, request: Request[Any]) -> None:
        """Accept every setpoint, because the handlers check them."""

    def superseded(self, request: Request[Any]) -> Collection[str]:
        return ()
