"""The command line: selects a command, and imports only the command's module."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from tool0.cli.edge import flush, interruptible, report

if TYPE_CHECKING:
    from tool0.cli.parameters import Readers

    Form = Callable[..., Any] | Mapping[str, Callable[..., Any]]

COMMANDS: Final[dict[str, tuple[str, str]]] = {
    "bringup": ("bringup", "bring up a robot in simulation, with its controllers"),
    "view": ("panel", "show and pose a robot without physics in a web page"),
    "record": ("recording", "record a running bringup, or demonstrations"),
    "log": ("recording", "print the events in a recording"),
    "export": ("recording", "write a recording as a table, a video or a data set"),
    "replay": ("replay", "show a recording in a web page, or repeat the simulation"),
    "demo": (
        "demo",
        "run a task: pick a cube from a table or a shelf, or hand a cube over",
    ),
    "collect": (
        "collect",
        "collect episodes of a task in parallel processes or with Ray",
    ),
    "policy": ("policy", "execute a learned policy in a task, or on a running bringup"),
    "describe": (
        "describe",
        "write the robot as a tree, a table, URDF or MJCF, or its controllers",
    ),
    "controllers": ("simulation", "list, load, start, stop or switch controllers"),
    "move": ("motion", "move joints to positions, or move the tool to a pose"),
    "grip": ("motion", "open or close the gripper"),
    "run": ("program", "run or check a program of steps"),
    "program": ("program", "list, save, delete or export programs"),
    "scene": ("scene", "list, add, remove or place objects around the robot"),
    "state": ("sensors", "print simulated time, joints, grippers and the tool's pose"),
    "wrench": ("sensors", "print force and torque at the wrist, or tare the sensor"),
    "camera": ("sensors", "take a picture with a camera, or list the cameras"),
    "pause": ("simulation", "pause simulated time"),
    "resume": ("simulation", "continue simulated time"),
    "step": ("simulation", "advance a paused simulation by control periods"),
    "reset": ("simulation", "return to time zero and the initial pose"),
    "estop": ("simulation", "engage or release the emergency stop"),
    "hardware": (
        "hardware",
        "enable or stop a real robot, or set its power, payload or speed",
    ),
    "gazebo": ("installing", "install Gazebo 11, or show which installation is used"),
    "ros1": (
        "installing",
        "install ROS 1 for `bringup --ros1`, or show what is installed",
    ),
    "ros2": ("ros2", "install ROS 2 for `bringup --ros2`, or show what is installed"),
    "check": ("check", "find errors in URDF, xacro, YAML and launch files"),
    "explain": (
        "explain",
        "show the contents of a launch file and the uses of its arguments",
    ),
    "workspace": ("workspace", "write ROS packages for a robot into a workspace"),
    "doctor": (
        "installing",
        "show which features this machine can run, and which software is missing",
    ),
    "completion": ("completion", "print a completion script for bash or zsh"),
}
"""Command → the command's module in this package, and a summary.

In the module, the function with the command's name executes the command: the function's
parameters are the options, and its return value is the exit status, or None for 0.
Alternatively, a mapping with the command's name contains one such function for each
subcommand.  A module whose options have special types provides ``READERS``, as the
module ``options`` does.
"""

OK: Final = 0
GOAL_FAILED: Final = 1
"""A goal was accepted but did not succeed."""
FAILED: Final = 2
"""The arguments were wrong, or an error occurred that is not a bug."""
INTERRUPTED: Final = 130
"""The command was interrupted by Ctrl-C.  Shells use the same status: 128 + SIGINT."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return the exit status of the process."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        try:
            return _carry_out(arguments)
        finally:
            flush()
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception as error:
        return FAILED if report(error) else OK


def _carry_out(arguments: list[str]) -> int:
    command = arguments[0] if arguments else "--help"
    if command in ("-h", "--help", "help"):
        print(_help())
        return OK
    if command in ("-V", "--version"):
        import tool0

        print(f"tool0 {tool0.__version__}")
        return OK
    if command not in COMMANDS:
        from tool0.errors import did_you_mean

        hint = did_you_mean(command, list(COMMANDS))
        print(f"tool0: error: unknown command '{command}'{hint}", file=sys.stderr)
        return FAILED
    return _run(command, arguments[1:])


def _run(command: str, arguments: list[str]) -> int:
    from tool0.cli.parsing import parse

    form, readers = form_and_readers(command)
    with interruptible():
        status = parse(form, command, arguments, readers, COMMANDS[command][1])
    return OK if status is None else int(status)


def form_and_readers(command: str) -> tuple[Form, Readers]:
    """Return the function or functions of a command, and the readers of its options."""
    from importlib import import_module

    module = import_module(f"tool0.cli.{COMMANDS[command][0]}")
    return getattr(module, command), getattr(module, "READERS", {})


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
            "`tool0 COMMAND --help` explains a command.  The commands from controllers",
            "to estop, and record, need a running bringup; --name selects one of",
            "several.",
        ]
    )
