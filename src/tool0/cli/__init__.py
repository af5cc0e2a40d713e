"""The command line: find the command, and import only its module.

``tyro`` takes 60 ms to import, a third of MuJoCo; so the list of commands is a plain
table here, and a command's module is imported only when it is called.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Final

COMMANDS: Final[dict[str, tuple[str, str]]] = {
    "bringup": ("bringup", "bring up a robot in simulation, with controllers"),
    "view": ("panel", "show a robot in a web page and pose it, without physics"),
    "demo": ("demo", "watch a complete task: pick a cube and place it in a bin"),
    "describe": ("describe", "write the robot as a tree, a table, URDF or MJCF"),
    "controllers": ("simulation", "list, load, start, stop or switch controllers"),
    "move": ("motion", "move joints, or the tool to a pose"),
    "grip": ("motion", "open or close the gripper"),
    "scene": ("scene", "list, add, remove or place objects around the robot"),
    "state": ("sensors", "print time and joints"),
    "wrench": ("sensors", "print force and torque at the wrist, or tare the sensor"),
    "camera": ("sensors", "take a picture with a camera, or list the cameras"),
    "pause": ("simulation", "pause simulated time"),
    "resume": ("simulation", "resume simulated time"),
    "step": ("simulation", "advance a paused simulation by some ticks"),
    "reset": ("simulation", "return to time zero and the initial pose"),
    "estop": ("simulation", "engage or release the emergency stop"),
    "gazebo": ("installing", "install a Gazebo 11, or show which one would run"),
    "ros1": (
        "installing",
        "install ROS 1 for bringup --ros1, or show what is installed",
    ),
    "check": ("check", "find mistakes in URDF, xacro, YAML and launch files"),
    "explain": ("explain", "explain what a launch file does and where arguments go"),
    "workspace": ("workspace", "write the robot as catkin packages for Noetic"),
    "doctor": ("installing", "show what this machine can run, and how to get the rest"),
}
"""Command → its module in this package, and a summary.

In the module, the function of the command's name carries it out: its parameters are
the options, and it returns the exit status, or None for 0.  In its place there may be
a mapping of subcommands to such functions.  ``bringup`` reads its options itself.
"""

OK: Final = 0
GOAL_FAILED: Final = 1
"""A goal was accepted but did not succeed."""
FAILED: Final = 2
"""Wrong arguments, or a Tool0Error."""
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

    module, summary = COMMANDS[command]
    try:
        function = getattr(import_module(f"tool0.cli.{module}"), command)
        if command == "bringup":  # without tyro, where possible
            status = function(arguments)
        elif command == "doctor" and not arguments:  # tyro may be what is missing
            status = function()
        else:
            from tool0.cli.options import READERS
            from tool0.cli.parsing import parse

            status = parse(function, command, arguments, READERS, summary)
    except Tool0Error as error:
        print(f"tool0: error: {error}", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:  # `tool0 describe tree | head`: what was read is enough
        sys.stderr.close()  # or the interpreter complains once more at exit
        return OK
    return OK if status is None else int(status)


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
            "`tool0 COMMAND --help` explains a command.  The commands controllers to",
            "estop need a running bringup; --name selects one of several.",
        ]
    )
