"""``tool0 state``: what the joints of a running bringup do now."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import tyro

from tool0.cli.connection import Bringup
from tool0.cli.grip import told
from tool0.cli.parsing import parse
from tool0.cli.text import columns
from tool0.description.transform import to_pose

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tool0.description.transform import Pose, Vector3
    from tool0.interfaces.socket.client import RemoteState

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
    """Print simulated time, every joint's motion, what grippers do, where tool0 is.

    Args:
        as_json: Print one JSON object.
        bringup: Which bringup.
    """
    with bringup.connect() as robot:
        measured = robot.joint_state
        ends = {name: to_pose(pose) for name, pose in robot.arm.poses().items()}
    if as_json:
        poses = {name: asdict(pose) for name, pose in ends.items()}
        print(json.dumps({**asdict(measured), "poses": poses}))
    else:
        print(_table(measured) + _poses(ends), end="")


def _poses(ends: Mapping[str, Pose]) -> str:
    """Return where the end of each arm is, as ``tool0 move --pose`` takes it."""
    return "".join(
        f"{name}: xyz {_numbers(pose.xyz)} m, rpy {_numbers(pose.rpy)} rad\n"
        for name, pose in ends.items()
    )


def _numbers(values: Vector3) -> str:
    return " ".join(f"{value:+.5f}" for value in values)


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
    grippers = "".join(
        f"{name}: {told(grasp)}\n" for name, grasp in state.grippers.items()
    )
    return f"{', '.join(marks)}\n{columns(rows)}{grippers}"
