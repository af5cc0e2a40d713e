"""``tool0 pause | resume | step | reset | estop``: the time of a running bringup."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Final

import tyro

from tool0.cli.connection import Bringup
from tool0.cli.parsing import parse
from tool0.errors import ConfigError

_DEFAULT = Bringup()


def run(command: str, arguments: list[str]) -> int:
    """Run the command and return its exit status."""
    parse(_COMMANDS[command], command, arguments)
    return 0


def pause(bringup: Bringup = _DEFAULT) -> None:
    """Hold simulated time."""
    with bringup.connect() as robot:
        robot.pause()


def resume(bringup: Bringup = _DEFAULT) -> None:
    """Let simulated time run on."""
    with bringup.connect() as robot:
        robot.resume()


def step(
    ticks: Annotated[int, tyro.conf.Positional] = 1, bringup: Bringup = _DEFAULT
) -> None:
    """Advance a paused simulation, and print the time it has then.

    Args:
        ticks: How many control periods.
        bringup: Which bringup.
    """
    if ticks < 1:
        raise ConfigError(f"step: need 1 or more ticks, got {ticks}")
    with bringup.connect() as robot:
        robot.step(ticks)
        print(f"t = {robot.time:.3f} s")


def reset(bringup: Bringup = _DEFAULT) -> None:
    """Go back to time zero and the initial pose; goals in progress are PREEMPTED."""
    with bringup.connect() as robot:
        robot.reset()


def estop(release: bool = False, bringup: Bringup = _DEFAULT) -> None:
    """Brake every joint at once, until the emergency stop is released.

    Args:
        release: Release it; the controllers hold where the robot is.
        bringup: Which bringup.
    """
    with bringup.connect() as robot:
        robot.emergency_stop(not release)


_COMMANDS: Final[dict[str, Callable[..., None]]] = {
    "pause": pause,
    "resume": resume,
    "step": step,
    "reset": reset,
    "estop": estop,
}
