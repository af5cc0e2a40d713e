"""What ``tool0 bringup`` tells a person: at the start, meanwhile, and at the end."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, TextIO, final

from tool0.cli.text import columns

if TYPE_CHECKING:
    from tool0.api.robot import Robot
    from tool0.cli.options import SimulationOptions


def panel_line(url: str) -> str:
    """Return where the panel is, as a line by itself."""
    return f"Panel: {url}"


def greeting(
    robot: Robot,
    simulation: SimulationOptions,
    url: str | None = None,
    ros: str | None = None,
) -> str:
    """Return what came up, and how to move it.

    Args:
        robot: The robot.
        simulation: How it runs.
        url: The panel's, if there is one.
        ros: A line on where it is in ROS, if it is.
    """
    description = robot.description
    parts = [item for item in (description.arm, description.gripper) if item]
    name = " + ".join(parts) or description.source.name
    pace = "real time" if simulation.realtime else "as fast as possible"
    n_joints = len(description.model.transmissions)
    lines = [
        f"{name} is up in {robot.engine.name}: {n_joints} driven joints, {pace}"
        f"{', paused' if simulation.paused else ''}",
        *columns(
            [(f"  {row.name}", row.state, row.type) for row in robot.controllers()]
        ).splitlines(),
    ]
    if simulation.grasp_assist:
        lines.append(
            "Grasp assist is on, a cheat: what is gripped is fixed to the hand."
        )
    lines += [] if url is None else [panel_line(url)]
    lines += [] if ros is None else [ros]
    if simulation.duration is None:
        if simulation.remote:
            lines += ["From another terminal:", *_examples(robot, simulation.name)]
        lines.append("Ctrl-C ends it.")
    return "\n".join(lines)


def _examples(robot: Robot, name: str) -> Iterator[str]:
    suffix = "" if name == "tool0" else f" --name {name}"
    position = robot.joint_state.position
    for row in robot.controllers():
        joints = [joint for _, joints in row.claimed for joint in joints]
        if row.state != "running" or not joints:
            continue
        if row.type.endswith("/JointTrajectoryController"):
            joint = joints[min(2, len(joints) - 1)]
            limits = robot.description.model.joint(joint).limits
            goal = limits.clamp(round(position[joint] + 0.5, 1))
            yield f"  tool0 move --joints {joint}={goal:g} --duration 2{suffix}"
            break
    if len(robot.grippers) == 1:
        opening = robot.gripper.geometry.max_opening / 2.0
        yield f"  tool0 grip --opening {opening:.2g}{suffix}"
    yield f"  tool0 state{suffix}"
    yield f"  tool0 controllers list{suffix}"


@final
class StatusLine:
    """One line on a terminal that is renewed once a second; elsewhere nothing."""

    def __init__(self, console: TextIO) -> None:
        self._console = console
        self._is_shown = console.isatty()
        self._next = time.monotonic() + 1.0

    def renew(self, robot: Robot) -> None:
        """Write the line again if a second has passed."""
        if not self._is_shown or time.monotonic() < self._next:
            return
        self._next = time.monotonic() + 1.0
        snapshot = robot.snapshot
        words = [
            f"t = {snapshot.time:.1f} s",
            f"{snapshot.real_time_factor:.2f} x real time",
            f"{snapshot.overruns} overruns",
        ]
        words += ["paused"] if snapshot.is_paused else []
        words += ["emergency stop"] if snapshot.is_stopped else []
        self._console.write(f"\r{', '.join(words)}\x1b[K")
        self._console.flush()

    def end(self) -> None:
        """Leave the line for what is written next."""
        if self._is_shown:
            self._console.write("\r\x1b[K")
            self._console.flush()


def summary_line(summary: dict[str, Any]) -> str:
    """Return the run in one line."""
    n_warnings = len(summary["warnings"])
    return (
        f"{summary['sim_time']:.3f} s simulated in {summary['wall_time']:.2f} s "
        f"({summary['real_time_factor']:.2f} x real time), {summary['steps']} steps, "
        f"{summary['overruns']} overruns, max drift {summary['max_drift']:.2e} rad, "
        f"{n_warnings} {'warning' if n_warnings == 1 else 'warnings'}"
    )


def finite(value: object) -> object:
    """Return ``value`` with null for what JSON has no number for."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return value
