"""Text for terminals: tables, progress, and the output of ``tool0 bringup``."""

from __future__ import annotations

import math
import shutil
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final, TextIO, final

if TYPE_CHECKING:
    from tool0.api.robot import Robot
    from tool0.cli.options import BringupOptions
    from tool0.protocol.gripper import GraspState
    from tool0.ur.options import UrArm

_BAR: Final = 24
"""Width of a progress bar [characters]."""


def columns(rows: Sequence[Sequence[str]]) -> str:
    """Return a line for each row; each column is as wide as its widest word."""
    if not rows:
        return ""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = (
        "  ".join(word.ljust(width) for word, width in zip(row, widths, strict=True))
        for row in rows
    )
    return "".join(f"{line.rstrip()}\n" for line in lines)


def counted(number: int, what: str) -> str:
    """Return a number with its noun, such as ``1 file`` or ``3 files``."""
    return f"{number} {what}" + ("" if number == 1 else "s")


def grasp_text(state: GraspState) -> str:
    """Return the state of a gripper as text, with Robotiq's number for this state."""
    opening = f"{1e3 * state.opening:.1f} mm"
    words = {
        "holding_inside": f"holds an object {opening} wide",
        "blocked": f"blocked without an object between the pads, open {opening}",
        "holding_outside": f"holds an object from inside, open {opening}",
        "at_target": f"open {opening}",
        "moving": f"moving, open {opening}",
    }
    if state.motion not in words:
        return f"open {opening}, not commanded"
    return f"{words[state.motion]} (gOBJ {state.gobj})"


def panel_line(url: str) -> str:
    """Return the line with the panel's URL."""
    return f"Panel: {url}"


def greeting(
    robot: Robot,
    options: BringupOptions,
    url: str | None = None,
    interfaces: Sequence[str] = (),
) -> str:
    """Return a description of the running robot, and commands that move it.

    Args:
        robot: The robot.
        options: Options of the bring-up.
        url: URL of the panel; None if there is no panel.
        interfaces: Lines about other interfaces to the robot, such as its ROS node.
    """
    description, simulation, run = robot.description, options.simulation, options.run
    name = description.title
    pace = "real time" if simulation.realtime else "as fast as possible"
    joints = counted(len(description.model.transmissions), "driven joint")
    first = f"{name} is up in {robot.engine.name}: {joints}, {pace}"
    if simulation.hardware is not None:
        first = _real_robot(robot, name)
    lines = [
        f"{first}{', paused' if simulation.paused else ''}",
        *columns(
            [(f"  {row.name}", row.state, row.type) for row in robot.controllers()]
        ).splitlines(),
    ]
    if simulation.grasp_assist:
        lines.append(
            "Grasp assist is on, a cheat: a gripped object is attached to the gripper."
        )
    lines += [] if url is None else [panel_line(url)]
    lines += interfaces
    if run.duration is None:
        if run.remote:
            lines += ["From another terminal:", *_examples(robot, run.name)]
        lines.append("Ctrl-C ends it.")
    return "\n".join(lines)


def _real_robot(robot: Robot, name: str) -> str:
    """Return the warnings that a user must read before a real robot moves."""
    link = robot.arm.control_box.state.link
    assert link is not None  # a real robot has a link
    who = f"{link.model} {link.serial_number}, PolyScope {link.software}"
    lines = [
        f"REAL ROBOT: {name} at {link.address} ({who}); tool0 only reads its state",
        "UR's safety system is the only safety function: keep the pendant's emergency "
        "stop in reach.",
        "tool0 has not been run on real hardware yet (docs/how-to/hardware.md).",
        *(f"  before it may move: {text}" for text in link.obstacles),
        *([f"  gripper: {link.gripper_problem}"] if link.gripper_problem else ()),
        "  tool0 hardware enable   lets it move",
    ]
    return "\n".join(lines)


def ur_lines(arms: Mapping[str, UrArm]) -> list[str]:
    """Return a line about the UR interface of each arm."""
    lines = []
    for name, arm in arms.items():
        title = arm.address if len(arms) == 1 else f"{arm.address} ({name})"
        line = f"UR: {title}: RTDE, dashboard server, URScript"
        if arm.modbus_port is not None:
            line += (
                f"; gripper: its socket, Modbus on {arm.modbus_port} and "
                f"{arm.serial_port}"
            )
        lines.append(line)
    return lines


def _examples(robot: Robot, name: str) -> Iterator[str]:
    from tool0.protocol.controllers import Role

    suffix = "" if name == "tool0" else f" --name {name}"
    position = robot.joint_state.position
    for row in robot.controllers():
        joints = [joint for _, joints in row.claimed for joint in joints]
        if not row.is_running or not joints:
            continue
        if row.role is Role.TRAJECTORY:
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
    """A status line, rewritten once per second; it appears only on a terminal."""

    def __init__(self, console: TextIO) -> None:
        self._console = console
        self._is_shown = console.isatty()
        self._next = time.monotonic() + 1.0

    def refresh(self, robot: Robot) -> None:
        """Rewrite the line if a second has passed."""
        if not self._is_shown or time.monotonic() < self._next:
            return
        self._next = time.monotonic() + 1.0
        snapshot = robot.snapshot
        words = [
            f"t = {snapshot.time:.1f} s",
            f"{snapshot.real_time_factor:.2f} x real time",
            f"{snapshot.late_ticks} late ticks in the last second",
        ]
        words += ["paused"] if snapshot.is_paused else []
        words += ["emergency stop"] if snapshot.is_stopped else []
        self._console.write(f"\r{', '.join(words)}\x1b[K")
        self._console.flush()

    def end(self) -> None:
        """Clear the line."""
        if self._is_shown:
            self._console.write("\r\x1b[K")
            self._console.flush()


@final
class ProgressBar:
    """A progress bar on a terminal; on other outputs, a line for each activity."""

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream = sys.stderr if stream is None else stream
        self._is_terminal = self._stream.isatty()
        self._shown = ""
        self._activity = ""

    def __enter__(self) -> ProgressBar:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the bar's line, so that the next output starts on a new line."""
        self._end_line()

    def __call__(self, activity: str, fraction: float, detail: str = "") -> None:
        """Show the completed ``fraction`` of the activity, from 0 to 1.

        On a terminal, the bar also shows ``detail``, which can change in each call.
        """
        if activity != self._activity and self._activity:
            self._end_line()
        is_new, self._activity = activity != self._activity, activity
        if self._is_terminal:
            text = f"{activity}: {detail}" if detail else activity
            self._draw(text, min(max(fraction, 0.0), 1.0))
        elif is_new:
            print(activity, file=self._stream, flush=True)

    def _draw(self, activity: str, fraction: float) -> None:
        done = int(fraction * _BAR)
        bar = "#" * done + "." * (_BAR - done)
        line = f"{bar} {100 * fraction:3.0f} %  {activity}"
        line = line[: shutil.get_terminal_size().columns - 1]
        if line != self._shown:
            self._stream.write(f"\r\x1b[K{line}")
            self._stream.flush()
            self._shown = line

    def _end_line(self) -> None:
        if self._shown:
            self._stream.write("\n")
            self._stream.flush()
        self._shown = ""


def summary_line(summary: dict[str, Any]) -> str:
    """Return a one-line summary of the run."""
    return (
        f"{summary['sim_time']:.3f} s simulated in {summary['wall_time']:.2f} s "
        f"({summary['real_time_factor']:.2f} x real time), {summary['steps']} steps, "
        f"{summary['overruns']} overruns, max drift {summary['max_drift']:.2e} rad, "
        f"{counted(len(summary['warnings']), 'warning')}"
    )


def json_text(value: object) -> str:
    """Return a value as a line of JSON, in ASCII; NaN and infinity are null."""
    import json

    from msgspec import to_builtins

    plain = finite(to_builtins(value))
    return json.dumps(plain, allow_nan=False) + "\n"


def print_json(value: object) -> None:
    """Print a value as a line of JSON."""
    print(json_text(value), end="", flush=True)


def finite(value: object) -> object:
    """Return ``value`` with NaN and infinity replaced by None, for JSON."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return value
