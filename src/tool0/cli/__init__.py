"""The command line: finds the command, and imports that command alone.

``tyro`` takes 60 ms to import, a third of MuJoCo; so the list of commands is a plain
table here, and a command's module is imported only when it is called.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Final

COMMANDS: Final[dict[str, tuple[str, str]]] = {
    "bringup": ("bringup", "bring a robot up in simulation, its controllers running"),
    "view": ("view", "show a robot in a web page and pose it, without physics"),
    "demo": ("demo", "watch a whole task: pick a cube and place it in a bin"),
    "describe": ("describe", "write the robot as a tree, a table, URDF or MJCF"),
    "controllers": ("controllers", "list, load, unload, start, stop or switch them"),
    "move": ("move", "move joints, or the tool to a pose"),
    "grip": ("grip", "open or close the gripper"),
    "scene": ("scene", "list, add, remove or place objects around the robot"),
    "state": ("state", "print time and joints"),
    "wrench": ("wrench", "print force and torque at the wrist, or zero them"),
    "camera": ("camera", "take a picture by a camera, or list them"),
    "pause": ("simulation", "hold simulated time"),
    "resume": ("simulation", "let simulated time run on"),
    "step": ("simulation", "advance a paused simulation by some ticks"),
    "reset": ("simulation", "go back to time zero and the initial pose"),
    "estop": ("simulation", "engage or release the emergency stop"),
    "gazebo": ("gazebo", "get a Gazebo 11 to simulate with, or see which would run"),
    "ros1": ("ros1", "get ROS 1 for bringup --ros1, or see what of it is there"),
    "check": ("check", "find what is wrong in URDF, xacro, YAML and launch files"),
    "explain": ("explain", "tell what a launch file does, and where arguments go"),
    "workspace": ("workspace", "write the robot as catkin packages, for Noetic"),
    "doctor": ("doctor", "tell what this machine can run, and how to get the rest"),
}
"""Command → its module in this package, and what it does."""

OK: Final = 0
GOAL_FAILED: Final = 1
"""A goal was accepted and did not succeed."""
FAILED: Final = 2
"""Bad arguments, or an error that is ours to report."""
INTERRUPTED: Final = 130
"""Ctrl-C, as shells count it: 128 + SIGINT."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return the exit status of the process."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    command = arguments[0] if arguments else "--help"
    if command in ("-h", "--help", "help"):
        print(_help())
        return OK
    if command in ("-V", "--version"):
        from importlib.metadata import version

        print(f"tool0 {version('tool0')}")
        return OK
    if command not in COMMANDS:
        from tool0.errors import did_you_mean

        hint = did_you_mean(command, list(COMMANDS))
        print(f"tool0: error: unknown command '{command}'{hint}", file=sys.stderr)
        return FAILED
    return _run(command, arguments[1:])


def _run(command: str, arguments: list[str]) -> int:
    from importlib import import_module

    from tool0.errors import Tool0Error

    module = import_module(f"tool0.cli.{COMMANDS[command][0]}")
    try:
        status: int = module.run(command, arguments)
    except Tool0Error as error:
        print(f"tool0: error: {error}", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:  # `tool0 describe tree | head`: what was read is enough
        sys.stderr.close()  # or the interpreter complains once more at exit
        return OK
    return status


def _help() -> str:
    width = max(map(len, COMMANDS))
    rows = [f"  {name:{width}}  {text}" for name, (_, text) in COMMANDS.items()]
    return "\n".join(
        [
            "usage: tool0 COMMAND [OPTIONS]",
            "",
            "A robot arm with a gripper in simulation, driven by real controllers.",
            "",
            *rows,
            "",
            "`tool0 COMMAND --help` explains a command.  All from controllers to estop",
            "talk to a bringup that runs: --name if there are several.",
        ]
    )
