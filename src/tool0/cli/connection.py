"""Parts shared by the commands that connect to a running bringup."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, final

from tool0.protocol.address import DEFAULT_NAME

if TYPE_CHECKING:
    from tool0.api.arm import Arm
    from tool0.api.controller import GoalHandle
    from tool0.api.gripper import Gripper
    from tool0.api.robot import Robot
    from tool0.protocol.goals import Result

_POLL_PERIOD: Final = 0.05
"""Longest time between checks of the signals [wall s]; the outcome of a goal ends the
wait immediately."""
_CANCEL_TIMEOUT: Final = 10.0
"""Longest wait for a canceled goal to end [wall s]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Bringup:
    """The running bringup."""

    name: str = DEFAULT_NAME
    """Name of the bringup, given by `tool0 bringup --name NAME`."""

    def connect(self) -> Robot:
        """Return the running robot; raise TransportError if no robot is running."""
        from tool0.api.connect import connect

        return connect(self.name)


DEFAULT: Final = Bringup()


def chosen_robot(robot: Robot, name: str | None) -> Arm:
    """Return the arm of the robot that ``--robot`` selects, or the only arm.

    Raises:
        ConfigError: If there are several robots and no name is given, or if there is no
            robot with this name.
    """
    from tool0.errors import ConfigError, did_you_mean

    names = list(robot.arms)
    if name is None:
        if len(names) > 1:
            raise ConfigError(f"which robot? give --robot {' | '.join(names)}")
        return robot.arm
    if name not in names:
        raise ConfigError(f"--robot: no robot '{name}'{did_you_mean(name, names)}")
    return robot.arms[name]


def chosen_gripper(robot: Robot, name: str | None) -> Gripper:
    """Return the gripper of the robot that ``--robot`` selects, or the only gripper.

    Raises:
        ConfigError: If there is no such robot, or if the robot has no gripper.
    """
    from tool0.description.parts import gripper_of
    from tool0.errors import ConfigError

    if name is None and len(robot.grippers) <= 1:
        return robot.gripper
    arm = chosen_robot(robot, name)
    gripper = gripper_of(robot.description.model, arm.name)
    if gripper is None:
        raise ConfigError(f"robot '{arm.name}' has no gripper")
    return robot.grippers[gripper]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """Outcome of a goal, for the command that started the goal."""

    status: int
    """The exit status."""
    result: Result
    """The result of the goal."""
    was_canceled: bool = False
    """Whether a signal or the timeout ended the goal."""

    def as_json(self) -> dict[str, object]:
        """Return the outcome in the form that ``--json`` prints."""
        from msgspec import to_builtins

        return {**to_builtins(self.result), "canceled": self.was_canceled}

    def __str__(self) -> str:
        """Return the outcome as a line of text."""
        text = _described(self.result)
        return f"canceled: {text}" if self.was_canceled else text


def wait_for_goal(
    robot: Robot, start: Callable[[], GoalHandle], timeout: float | None
) -> Outcome:
    """Start a goal, wait for it, and return its outcome; see ``wait_for_goals``."""
    return wait_for_goals(robot, lambda: (start(),), timeout)


def wait_for_goals(
    robot: Robot, start: Callable[[], Sequence[GoalHandle]], timeout: float | None
) -> Outcome:
    """Start goals, wait until all have ended, and return the first failure.

    If no goal failed, return the last outcome.  Ctrl-C and SIGTERM cancel the goals:
    the robot stops in the same way as when a ROS client cancels its goals.  The signal
    handlers are installed before the goals start, so that no signal is missed.
    """
    from tool0.cli import GOAL_FAILED, INTERRUPTED, OK
    from tool0.cli.stop_signal import StopSignal
    from tool0.errors import GoalTimeoutError

    end = math.inf if timeout is None else time.monotonic() + timeout
    with StopSignal() as stop:
        goals = start()
        if robot.snapshot.is_paused:
            hint = "the simulation is paused; continue with `tool0 resume`"
            print(hint, file=sys.stderr, flush=True)
        for goal in goals:
            while goal.result is None:
                try:
                    goal.wait(_POLL_PERIOD)
                except GoalTimeoutError:
                    if not stop.is_set and time.monotonic() < end:
                        continue
                    for each in goals:
                        each.cancel()
                    result = _decisive([each.wait(_CANCEL_TIMEOUT) for each in goals])
                    status = INTERRUPTED if stop.is_set else GOAL_FAILED
                    return Outcome(status=status, result=result, was_canceled=True)
    result = _decisive([goal.wait(_POLL_PERIOD) for goal in goals])
    status = OK if _has_succeeded(result) else GOAL_FAILED
    return Outcome(status=status, result=result)


def _decisive(results: Sequence[Result]) -> Result:
    """Return the first unsuccessful result, or the last result if all succeeded."""
    failed = (result for result in results if not _has_succeeded(result))
    return next(failed, results[-1])


def _has_succeeded(result: Result) -> bool:
    from tool0.protocol.goals import GoalStatus

    return result.status is GoalStatus.SUCCEEDED


def _described(result: Result) -> str:
    from tool0.protocol.goals import GoalResult

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
