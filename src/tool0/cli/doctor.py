"""``tool0 doctor``: what this machine can run, and how to get what is missing."""

from __future__ import annotations

from typing import Literal

from tool0.cli.installing import print_status
from tool0.cli.parsing import parse


def run(command: str, arguments: list[str]) -> int:
    """Run the command and return its exit status."""
    if not arguments:
        return doctor()  # without tyro, which may be what is missing
    return parse(doctor, command, arguments)


def doctor(*, format: Literal["text", "json"] = "text") -> int:
    """Print what this machine can run, and the command that installs what is missing.

    Status 1 if it cannot run `tool0 bringup`, that is the robot in MuJoCo.

    Args:
        format: For people or for programs.
    """
    from tool0.installation.doctor.report import examine

    return print_status(examine(), format)
