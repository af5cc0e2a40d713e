"""A backend: a robot behind the contract, simulated or not.

It answers requests, publishes states, and says what it does not offer.  A server, the
Python API and what is built on them know nothing else of it.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, Any, Protocol

from tool0.errors import NotOfferedError
from tool0.protocol.methods import methods
from tool0.protocol.request import Request, method_name

if TYPE_CHECKING:
    from tool0.description.robot import RobotDescription
    from tool0.protocol.bus import Subscription
    from tool0.protocol.codec import Mode
    from tool0.protocol.fork_guard import OwnProcess
    from tool0.protocol.goal_registry import GoalRegistry
    from tool0.protocol.goals import Goal
    from tool0.protocol.sensors import CameraRenderer
    from tool0.protocol.state import Snapshot


class Observed(Protocol):
    """A robot in time, in this process or another one."""

    @property
    def description(self) -> RobotDescription: ...

    @property
    def snapshot(self) -> Snapshot:
        """The newest state."""

    @property
    def time(self) -> float:
        """The robot's time now, which may be later than the newest state [s]."""

    def wait_until(self, is_over: Callable[[], bool], timeout: float | None) -> bool:
        """Advance time until ``is_over()``; return False on a timeout.

        Args:
            is_over: Polled repeatedly.
            timeout: Longest simulated time [s] where the caller makes time pass,
                otherwise longest wall time; None waits without limit.

        Raises:
            EngineError: If the physics failed.
            ControlError: If the robot was closed, or is paused without real time.
            TransportError: If it is in another process, which has ended.
        """

    def wait_for_goal(self, goal: Goal, timeout: float | None) -> bool:
        """Advance time until ``goal`` ends, as ``wait_until`` does."""


class States(Observed, Protocol):
    """The states of a robot of this process."""

    @property
    def goals(self) -> GoalRegistry:
        """The goals that requests have started, by number."""

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
        """Return a reader of snapshots and events, as ``Bus.subscribe`` does.

        Args:
            rate: Snapshots per second of the robot's time [Hz]; the default rate if
                left out.
            keep_all: As for ``Bus.subscribe``, and so the rest.
            with_commands: The snapshots have the commands of the joints.
            with_arms: They have what moves each arm, and the wrench on its tool.
            with_contacts: They have contacts and their forces.
            latest_only: Events, and the newest snapshot only.
            when_published: Called for every snapshot.

        Raises:
            ControlError: For a rate that is not offered.
        """

    @property
    def cameras(self) -> CameraRenderer | None:
        """Renderer of camera images; None if there is none."""

    def refresh(self) -> None:
        """Publish a snapshot soon, also while time is held."""

    def snapshot_with_arms(self) -> Snapshot:
        """Return the newest state with what moves each arm; it may wait for it."""

    @property
    def process(self) -> OwnProcess:
        """The process that owns the robot, and alone can use and close it."""

    def close(self) -> None:
        """End the robot; closing twice is allowed."""


class Backend(Protocol):
    """Answers the requests of all clients.

    ``answer`` may take time and is called by worker threads; the rest is called by
    the server's thread alone.  It is given only requests that the backend offers, and
    none of ``Request.is_of_connection``.
    """

    @property
    def mode(self) -> Mode: ...

    @property
    def states(self) -> States | None:
        """The states as clients of the contract read them; None for a mere picture."""

    def why_missing(self, request: type[Request[Any]]) -> str:
        """Return why requests of a class are not offered; empty if they are."""

    def answer(self, request: Request[Any]) -> Any:
        """Return the response to a checked request that is offered.

        Raises:
            Tool0Error: If it cannot be carried out.
        """

    def post(
        self, request: Request[Any], when_failed: Callable[[Exception], None]
    ) -> None:
        """Queue a request of a stream for the next tick, or raise Tool0Error.

        ``when_failed`` may be called in any thread.
        """

    def check_setpoint(self, request: Request[Any]) -> None:
        """Raise Tool0Error for a streamed setpoint that can never be carried out."""

    def superseded(self, request: Request[Any]) -> Collection[str]:
        """Return the controllers whose setpoint streams are ended by a request."""


def missing(request: type[Request[Any]], reason: str) -> NotOfferedError:
    """Return the error for a request that a backend does not offer."""
    return NotOfferedError(f"'{method_name(request)}' is not offered: {reason}")


def missing_methods(backend: Backend) -> dict[str, str]:
    """Return each method of the contract that a backend does not offer, and why."""
    reasons = {
        name: backend.why_missing(request)
        for name, request in methods().items()
        if not request.is_of_connection
    }
    return {name: reason for name, reason in reasons.items() if reason}
