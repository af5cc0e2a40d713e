"""Channels that connect API objects to a robot in this process or over a socket."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NoReturn, Protocol, TypeVar, final, runtime_checkable

from tool0.errors import ControlError
from tool0.protocol.backend import Observed, missing
from tool0.protocol.fork_guard import refuse_pickle
from tool0.protocol.goals import Goal, GoalStarted
from tool0.protocol.request import Request, checked

if TYPE_CHECKING:
    from tool0.description.robot import RobotDescription
    from tool0.protocol.backend import Backend, States
    from tool0.protocol.bus import Subscription
    from tool0.protocol.sensors import CameraRenderer
    from tool0.protocol.state import Snapshot

R = TypeVar("R")


class Channel(Observed, Protocol):
    """A connection to a robot."""

    def call(self, request: Request[R]) -> R:
        """Return the response, or raise the handler's error."""

    def goal(self, started: GoalStarted) -> Goal:
        """Return the goal that a request on this channel has just started."""

    def subscribe(
        self, rate: float | None = None, *, keep_all: bool = False
    ) -> Subscription:
        """Return a reader of snapshots and events at ``rate`` [Hz].

        With ``keep_all``, every snapshot is stored until the reader takes it.
        """

    def close(self) -> None:
        """End the simulation, or the connection to it."""


@final
class LocalChannel:
    """A connection to a robot whose backend is in this process."""

    def __init__(self, backend: Backend) -> None:
        """Connect to a backend that has states."""
        states = backend.states
        assert states is not None
        self._backend, self._states = backend, states
        self._process = states.process

    def __reduce__(self) -> NoReturn:
        refuse_pickle()

    @property
    def backend(self) -> Backend:
        """The backend; access in a forked child process raises ControlError."""
        self._process.check()
        return self._backend

    @property
    def _robot(self) -> States:
        self._process.check()
        return self._states

    @property
    def description(self) -> RobotDescription:
        return self._robot.description

    @property
    def snapshot(self) -> Snapshot:
        return self._robot.snapshot

    @property
    def time(self) -> float:
        return self._robot.time

    def call(self, request: Request[R]) -> R:
        backend = self.backend
        if reason := backend.why_missing(type(request)):
            raise missing(type(request), reason)
        response: R = backend.answer(checked(request))
        return response

    @property
    def cameras(self) -> CameraRenderer | None:
        """Renderer of camera images in this process; None if there is no renderer."""
        return self._robot.cameras

    def goal(self, started: GoalStarted) -> Goal:
        return self._robot.goals.find(started.goal)

    def wait_until(self, is_over: Callable[[], bool], timeout: float | None) -> bool:
        return self._robot.wait_until(is_over, timeout)

    def wait_for_goal(self, goal: Goal, timeout: float | None) -> bool:
        return self._robot.wait_for_goal(goal, timeout)

    def subscribe(
        self, rate: float | None = None, *, keep_all: bool = False
    ) -> Subscription:
        return self._robot.subscribe(rate, keep_all=keep_all)

    def close(self) -> None:
        if self._process.is_this:  # only the parent of a forked child closes the robot
            self._states.close()


@runtime_checkable
class Connected(Protocol):
    """A robot object with a channel, such as ``tool0.Robot``."""

    @property
    def channel(self) -> Channel: ...


def backend_of(channel: Channel) -> Backend:
    """Return the backend behind a channel, for servers.

    Raises:
        ControlError: If the backend is in another process.
    """
    if not isinstance(channel, LocalChannel):
        raise ControlError("the simulation runs in another process")
    return channel.backend
