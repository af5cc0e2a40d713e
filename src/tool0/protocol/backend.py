"""A backend: a simulated or real robot that implements the contract.

A backend answers requests, publishes states, and reports the requests that it does not
offer.  Servers, the Python API and their clients use only this interface.
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
    """A robot with a time-dependent state, in this process or in another process."""

    @property
    def description(self) -> RobotDescription: ...

    @property
    def snapshot(self) -> Snapshot:
        """The newest state."""

    @property
    def time(self) -> float:
        """The current time of the robot [s]; it can be later than the newest state."""

    def wait_until(self, is_over: Callable[[], bool], timeout: float | None) -> bool:
        """Advance time until ``is_over()``; return False on a timeout.

        Args:
            is_over: Condition that is polled repeatedly.
            timeout: Longest wait [s], or None for no limit.  If time passes only on
                request, the limit is in simulated time; otherwise, the limit is in wall
                time.

        Raises:
            EngineError: If the physics failed.
            ControlError: If the robot was closed, or is paused and does not run in real
                time.
            TransportError: If the robot is in another process, and that process has
                ended.
        """

    def wait_for_goal(self, goal: Goal, timeout: float | None) -> bool:
        """Advance time until ``goal`` ends; see ``wait_until``."""


class States(Observed, Protocol):
    """States of a robot in this process."""

    @property
    def goals(self) -> GoalRegistry:
        """Registry of the goals that requests have started."""

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
        """Return a reader of snapshots and events; see ``Bus.subscribe``.

        Args:
            rate: Snapshots per second of the robot's time [Hz]; the default is 125 Hz.
            keep_all: Whether ``pending`` returns every snapshot.
            with_commands: Whether snapshots contain the joints' commands.
            with_arms: Whether snapshots contain each arm's motion and the wrench on the
                arm's tool.
            with_contacts: Whether snapshots contain contacts with their forces.
            latest_only: Whether the reader needs only events and the newest snapshot.
            when_published: Callback for every snapshot.

        Raises:
            ControlError: If the rate is not offered.
        """

    @property
    def cameras(self) -> CameraRenderer | None:
        """Renderer of camera images; None if the robot has no renderer."""

    def refresh(self) -> None:
        """Publish a snapshot as soon as possible, even while time is paused."""

    def snapshot_with_arms(self) -> Snapshot:
        """Return the newest state with the arms' motions, possibly after a wait."""

    @property
    def process(self) -> OwnProcess:
        """The process that owns the robot; only this process can use and close it."""

    def close(self) -> None:
        """Close the robot; further calls have no effect."""


class Backend(Protocol):
    """Interface that answers the requests of all clients.

    Worker threads call ``answer``, which may take time; the server's thread calls all
    other methods.  ``answer`` receives only requests that the backend offers and for
    which ``is_of_connection`` is false.
    """

    @property
    def mode(self) -> Mode: ...

    @property
    def states(self) -> States | None:
        """The states that clients read; None without a live robot (in a replay)."""

    def why_missing(self, request: type[Request[Any]]) -> str:
        """Return why a class of requests is not offered; empty if it is offered."""

    def answer(self, request: Request[Any]) -> Any:
        """Return the response to a checked request that the backend offers.

        Raises:
            Tool0Error: If the request cannot be executed.
        """

    def post(
        self, request: Request[Any], when_failed: Callable[[Exception], None]
    ) -> None:
        """Queue a streamed request for the next tick; a refusal raises Tool0Error.

        ``when_failed`` can be called in any thread.
        """

    def check_setpoint(self, request: Request[Any]) -> None:
        """Raise Tool0Error for a streamed setpoint that can never be executed."""

    def superseded(self, request: Request[Any]) -> Collection[str]:
        """Return the controllers whose setpoint streams a request ends."""


def missing(request: type[Request[Any]], reason: str) -> NotOfferedError:
    """Return the error for requests that a backend does not offer."""
    return NotOfferedError(f"'{method_name(request)}' is not offered: {reason}")


def missing_methods(backend: Backend) -> dict[str, str]:
    """Return the methods that a backend does not offer: method name → reason."""
    reasons = {
        name: backend.why_missing(request)
        for name, request in methods().items()
        if not request.is_of_connection
    }
    return {name: reason for name, reason in reasons.items() if reason}
