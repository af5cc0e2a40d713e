"""``tool0 state``: what the joints of a running bringup do now."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import tyro

from tool0.cli.connection import Bringup
from tool0.cli.grip import described
from tool0.cli.parsing import parse
from tool0.cli.text import columns
from tool0.description.transform import to_pose

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tool0.description.transform import Pose, Vector3
    from tool0.sensing.grasp import GraspState
    from tool0.sensing.snapshot import Snapshot

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
        snapshot = robot.snapshot
        grippers = {name: item.state for name, item in robot.grippers.items()}
        tools = {arm.tip: to_pose(arm.pose()) for arm in robot.arms.values()}
    if as_json:
        print(json.dumps(_plain(snapshot, grippers, tools)))
    else:
        print(_table(snapshot, grippers) + _poses(tools), end="")


def _plain(
    snapshot: Snapshot, grippers: Mapping[str, GraspState], tools: Mapping[str, Pose]
) -> dict[str, object]:
    names = snapshot.joint_names
    return {
        "time": snapshot.time,
        "is_paused": snapshot.is_paused,
        "is_stopped": snapshot.is_stopped,
        "real_time_factor": snapshot.real_time_factor,
        "overruns": snapshot.overruns,
        "fault": snapshot.fault,
        "position": dict(zip(names, snapshot.position, strict=True)),
        "velocity": dict(zip(names, snapshot.velocity, strict=True)),
        "effort": dict(zip(names, snapshot.effort, strict=True)),
        "grippers": {
            name: {**asdict(state), "gobj": state.gobj}
            for name, state in grippers.items()
        },
        "poses": {name: asdict(pose) for name, pose in tools.items()},
    }


def _poses(ends: Mapping[str, Pose]) -> str:
    """Return where the end of each arm is, as ``tool0 move --pose`` takes it."""
    return "".join(
        f"{name}: xyz {_numbers(pose.xyz)} m, rpy {_numbers(pose.rpy)} rad\n"
        for name, pose in ends.items()
    )


def _numbers(values: Vector3) -> str:
    return " ".join(f"{value:+.5f}" for value in values)


def _table(snapshot: Snapshot, grippers: Mapping[str, GraspState]) -> str:
    marks = [f"t = {snapshot.time:.3f} s"]
    if snapshot.real_time_factor > 0.0:  # zero until it was measured for a second
        marks.append(f"{snapshot.real_time_factor:.2f} x real time")
    if snapshot.is_paused:
        marks.append("paused")
    if snapshot.is_stopped:
        marks.append("emergency stop")
    if snapshot.fault is not None:
        marks.append(f"standing still: {snapshot.fault}")
    rows = [("joint", "position", "velocity", "effort")]
    rows += [
        (name, f"{position:+.5f}", f"{velocity:+.5f}", f"{effort:+.3f}")
        for name, position, velocity, effort in zip(
            snapshot.joint_names,
            snapshot.position,
            snapshot.velocity,
            snapshot.effort,
            strict=True,
        )
    ]
    lines = "".join(f"{name}: {described(state)}\n" for name, state in grippers.items())
    return f"{', '.join(marks)}\n{columns(rows)}{lines}"
