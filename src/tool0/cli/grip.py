"""``tool0 grip``: the gripper of a running bringup."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from tool0.cli import INTERRUPTED
from tool0.cli.connection import Bringup, wait_for_goal
from tool0.cli.parsing import parse
from tool0.errors import ConfigError, GoalTimeoutError

if TYPE_CHECKING:
    from tool0.api.gripper import Gripper
    from tool0.sensing.grasp import GraspState

_DEFAULT = Bringup()
_SETTLE = 1.0
"""Longest wait, after a goal has ended, for the pads to stand still [wall s]."""


def run(command: str, arguments: list[str]) -> int:
    """Run the command and return its exit status."""
    return parse(grip, command, arguments)


def described(state: GraspState) -> str:
    """Return what a gripper does, for people, with Robotiq's number for it."""
    opening = f"{1e3 * state.opening:.1f} mm"
    words = {
        "holding_inside": f"holds something {opening} wide",
        "holding_outside": f"presses against something outside, open {opening}",
        "at_target": f"open {opening}",
        "moving": f"moving, open {opening}",
    }
    if state.motion not in words:
        return f"open {opening}, commanded by nobody"
    return f"{words[state.motion]} (gOBJ {state.gobj})"


def _settled(gripper: Gripper) -> GraspState:
    """Return the state once the pads stand still, or after a while."""
    try:
        return gripper.wait(_SETTLE)
    except GoalTimeoutError:
        return gripper.state


def grip(
    *,
    opening: float | None = None,
    position: float | None = None,
    speed: float | None = None,
    force: float | None = None,
    effort: float | None = None,
    timeout: float | None = None,
    bringup: Bringup = _DEFAULT,
) -> int:
    """Open or close the gripper, wait, and tell what it holds; Ctrl-C stops it.

    Args:
        opening: Distance between the pads [m]; 0 is closed.
        position: Instead of that, the position of the driven joint [rad].
        speed: Of the pads towards each other [m/s]; 0.02 to 0.15 for a 2F-85.
        force: Largest force at each pad [N]; 20 to 235 for a 2F-85.
        effort: Instead of that, the largest torque at the driven joint [N·m].
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
            force=force,
            effort=effort,
        )
        status = wait_for_goal(robot, move, timeout)
        if status != INTERRUPTED:
            print(described(_settled(robot.gripper)))
    return status
