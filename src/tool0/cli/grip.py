"""``tool0 grip``: the gripper of a running bringup."""

from __future__ import annotations

from functools import partial

from tool0.cli.connection import Bringup, see_through
from tool0.cli.parsing import parse
from tool0.errors import ConfigError

_DEFAULT = Bringup()


def run(command: str, arguments: list[str]) -> int:
    """Run the command and return its exit status."""
    return parse(grip, command, arguments)


def grip(
    *,
    opening: float | None = None,
    position: float | None = None,
    speed: float | None = None,
    effort: float | None = None,
    timeout: float | None = None,
    bringup: Bringup = _DEFAULT,
) -> int:
    """Open or close the gripper, and wait until it is there; Ctrl-C stops it.

    Args:
        opening: Distance between the pads [m]; 0 is closed.
        position: Instead of that, the position of the driven joint [rad].
        speed: Of the pads towards each other [m/s].
        effort: Largest torque at the driven joint [N·m].
        timeout: Stop after so many wall seconds.
        bringup: Which bringup.
    """
    if (opening is None) == (position is None):
        raise ConfigError("give either --opening [m] or --position [rad]")
    with bringup.connect() as robot:
        move = partial(
            robot.gripper.move,
            opening=opening,
            position=position,
            speed=speed,
            effort=effort,
        )
        return see_through(move, timeout)
