"""``tool0 state``: what the joints of a running bringup do now."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import tyro

from tool0.cli.connection import Bringup
from tool0.cli.parsing import parse
from tool0.cli.text import columns

if TYPE_CHECKING:
    from tool0.remote.client import RemoteState

_DEFAULT = Bringup()


def run(command: str, arguments: list[str]) -> int:
    """Run the command and return its exit status."""
    parse(state, command, arguments)
    return 0


def state(
    *,
    as_json: Annotated[bool, tyro.conf.arg(name="json")] = False,
    bringup: Bringup = _DEFAULT,
) -> None:
    """Print simulated time and every joint's position, velocity and effort.

    Args:
        as_json: Print one JSON object.
        bringup: Which bringup.
    """
    with bringup.connect() as robot:
        measured = robot.joint_state
    if as_json:
        print(json.dumps(asdict(measured)))
    else:
        print(_table(measured), end="")


def _table(state: RemoteState) -> str:
    marks = [f"t = {state.time:.3f} s"]
    if state.real_time_factor > 0.0:  # zero until it was measured for a second
        marks.append(f"{state.real_time_factor:.2f} x real time")
    if state.is_paused:
        marks.append("paused")
    if state.is_stopped:
        marks.append("emergency stop")
    if state.fault is not None:
        marks.append(f"standing still: {state.fault}")
    rows = [("joint", "position", "velocity", "effort")]
    rows += [
        (
            name,
            f"{state.position[name]:+.5f}",
            f"{state.velocity[name]:+.5f}",
            f"{state.effort[name]:+.3f}",
        )
        for name in state.position
    ]
    return f"{', '.join(marks)}\n{columns(rows)}"
