"""What the commands that talk to a running bringup have in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

from tool0.remote.address import DEFAULT_NAME

if TYPE_CHECKING:
    from tool0.control.goal import Result
    from tool0.remote.client import RemoteGoal, RemoteRobot


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Bringup:
    """Which bringup."""

    name: str = DEFAULT_NAME
    """The --name of the bringup."""

    def connect(self) -> RemoteRobot:
        """Return the running robot, or raise TransportError."""
        from tool0.remote.client import RemoteRobot

        return RemoteRobot(self.name)


def see_through(goal: RemoteGoal, timeout: float | None) -> int:
    """Wait for ``goal``, tell how it ended, and return the exit status.

    Ctrl-C cancels the goal: the robot stops as it does for a ROS client.
    """
    from tool0.cli import GOAL_FAILED, INTERRUPTED, OK
    from tool0.control.goal import GoalStatus
    from tool0.errors import GoalTimeoutError

    try:
        result = goal.wait(timeout)
    except KeyboardInterrupt:
        goal.cancel()
        print(f"canceled: {_told(goal.wait(10.0))}")
        return INTERRUPTED
    except GoalTimeoutError:
        goal.cancel()
        print(f"canceled after {timeout:g} s: {_told(goal.wait(10.0))}")
        return GOAL_FAILED
    print(_told(result))
    return OK if result.status is GoalStatus.SUCCEEDED else GOAL_FAILED


def _told(result: Result) -> str:
    from tool0.control.goal import GoalResult

    if isinstance(result, GoalResult):
        reason = f": {result.error_string}" if result.error_string else ""
        code = f" ({result.error_code})" if result.error_code else ""
        return f"{result.status.value}{code}{reason}"
    reached = "reached" if result.reached_goal else "not reached"
    stalled = ", holding something or blocked" if result.stalled else ""
    return (
        f"{result.status.value}: {reached}{stalled}, at {result.position:.4f} rad "
        f"with {result.effort:.2f} N·m"
    )
