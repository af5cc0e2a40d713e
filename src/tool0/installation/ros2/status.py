"""The status of ROS 2 on this machine, and the environment variables for a terminal."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, TypedDict, final

from tool0.errors import RosUnavailableError
from tool0.installation.child_process import last_lines, run_program
from tool0.installation.ros2.install import expected_prefix
from tool0.installation.ros2.installation import (
    NODE_FOLDER,
    Ros2,
    find_ros2,
    read_marker,
)

NEEDED: Final = (
    *("rclpy", "control_msgs", "controller_manager_msgs", "tf2_msgs"),
    *("sensor_msgs", "geometry_msgs", "trajectory_msgs", "rosgraph_msgs"),
    *("std_msgs", "std_srvs", "lifecycle_msgs"),
)
"""Packages that the node imports."""
OPTIONAL: Final = {
    "ur_msgs": "inputs, outputs, payload and speed slider of the arm",
    "ur_dashboard_msgs": "robot mode, safety mode and dashboard of the arm",
    "simulation_interfaces": "services that pause, step, reset and spawn",
}
"""Feature of the node that requires the package, by package."""
INSTALL: Final = "tool0 ros2 install"
_TIMEOUT: Final = 30.0
"""Time limit of the program below [wall s].  The program takes about 1 s."""
_PROGRAM: Final = """\
import importlib, json, platform, sys

answer = {"python": platform.python_version(), "failures": {}}
for name in sys.argv[1:]:
    try:
        importlib.import_module(name)
    except ImportError as error:
        answer["failures"][name] = str(error)
if "rclpy" not in answer["failures"]:
    answer["rmw"] = importlib.import_module(
        "rclpy.utilities"
    ).get_rmw_implementation_identifier()
print(json.dumps(answer))
"""


class Ros2Json(TypedDict):
    """The status as data for JSON; null if there is no ROS 2."""

    can_run: bool
    """Whether the node can start."""
    kind: str | None
    """Origin of ROS 2."""
    distro: str | None
    """Distribution of ROS 2, such as ``jazzy``."""
    prefix: str | None
    """Folder of ROS 2."""
    python: str | None
    """The Python that ROS 2 uses."""
    python_version: str | None
    """Version of this Python."""
    rclpy: str | None
    """Version of rclpy."""
    rmw: str | None
    """Name of the RMW middleware, such as ``rmw_fastrtps_cpp``."""
    size: int | None
    """Size of tool0's own ROS 2 on disk [bytes]."""
    missing: dict[str, str]
    """Reason why a package cannot be imported, by package."""
    remedies: tuple[str, ...]
    """Commands that install the missing parts."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Ros2Status:
    """The output of ``tool0 ros2 status``."""

    ros2: Ros2 | None = None
    """The ROS 2 that tool0 would run; None if there is none."""
    python: str | None = None
    """Version of the Python that ROS 2 uses."""
    rclpy: str | None = None
    """Version of rclpy."""
    rmw: str | None = None
    """Name of the RMW middleware, such as ``rmw_fastrtps_cpp``."""
    size: int | None = None
    """Size of tool0's own ROS 2 on disk [bytes]."""
    missing: dict[str, str] = field(default_factory=dict)
    """Reason why a package cannot be imported, by package."""
    remedies: tuple[str, ...] = ()
    """Commands that install the missing parts."""

    @property
    def can_run(self) -> bool:
        """Whether the node can start."""
        return self.ros2 is not None and self.missing.keys().isdisjoint(NEEDED)

    def as_json(self) -> Ros2Json:
        """Return the status as data for JSON."""
        found = self.ros2
        return {
            "can_run": self.can_run,
            "kind": found and found.kind,
            "distro": found and found.distro,
            "prefix": found and str(found.prefix),
            "python": found and str(found.python),
            "python_version": self.python,
            "rclpy": self.rclpy,
            "rmw": self.rmw,
            "size": self.size,
            "missing": self.missing,
            "remedies": self.remedies,
        }

    def rows(self) -> list[tuple[str, str]]:
        """Return the names and values of the status as text."""
        if (found := self.ros2) is None:
            rows = [("ros2", "none")]
        else:
            size = "" if self.size is None else f", {self.size / 1e6:.0f} MB"
            rows = [
                ("ros2", f"{found.distro}, {found.origin}{size}, {found.prefix}"),
                ("python", f"{self.python or 'does not start'}, {found.python}"),
                ("rclpy", f"{self.rclpy or 'none'}, {self.rmw or 'no middleware'}"),
                ("node", "can start" if self.can_run else "cannot start"),
            ]
        for name, reason in self.missing.items():
            purpose = f"; for {OPTIONAL[name]}" if name in OPTIONAL else ""
            rows.append((name, f"{reason}{purpose}"))
        return [*rows, *(("to do", text) for text in self.remedies)]


def ros2_status() -> Ros2Status:
    """Return the status.  The Python of ROS 2 is run briefly."""
    found = find_ros2()
    if found is None:
        return Ros2Status(remedies=(INSTALL,))
    try:
        answer = _probe(found)
    except RosUnavailableError as error:
        return Ros2Status(
            ros2=found,
            missing={"rclpy": str(error)},
            remedies=_remedies(found, ["rclpy"]),
        )
    missing: dict[str, str] = answer["failures"]
    return Ros2Status(
        ros2=found,
        python=answer["python"],
        rclpy=found.version("rclpy"),
        rmw=answer.get("rmw"),
        size=(read_marker(found.prefix) or {}).get("size"),
        missing=missing,
        remedies=_remedies(found, missing),
    )


def _probe(found: Ros2) -> dict[str, Any]:
    """Return the versions and import failures that ROS 2's Python reports."""
    command = [str(found.python), "-c", _PROGRAM, *NEEDED, *OPTIONAL]
    try:
        done = run_program(command, environment=found.environment, timeout=_TIMEOUT)
    except subprocess.TimeoutExpired:
        raise RosUnavailableError(
            f"'{found.python}' does not answer within {_TIMEOUT:.0f} s"
        ) from None
    try:
        answer: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    except (ValueError, IndexError):
        reason = last_lines(done.stderr or done.stdout, 3)
        raise RosUnavailableError(f"'{found.python}' fails:\n{reason}") from None
    return answer


def _remedies(found: Ros2, missing: Iterable[str]) -> tuple[str, ...]:
    if found.kind == "own":
        is_stale = found.prefix != expected_prefix()
        return (INSTALL,) if is_stale or list(missing) else ()
    packages = [f"ros-{found.distro}-{name.replace('_', '-')}" for name in missing]
    if not packages:
        return ()
    if found.prefix.joinpath("conda-meta").is_dir():  # this is RoboStack
        channels = f"-c conda-forge -c robostack-{found.distro}"
        return (f"mamba install {channels} {' '.join(packages)}",)
    return (f"sudo apt install {' '.join(packages)}",)


# --- terminals ---


def shell_exports(environ: Mapping[str, str] | None = None) -> list[str]:
    """Return POSIX shell commands that set up ROS 2 and tool0's node.

    Args:
        environ: Environment variables of the shell.

    Raises:
        RosUnavailableError: If there is no ROS 2.
    """
    before = dict(os.environ if environ is None else environ)
    found = find_ros2(before)
    if found is None:
        raise RosUnavailableError(f"there is no ROS 2 here; run: {INSTALL}")
    after = dict(found.environment)
    # The shell keeps its other programs, including tool0, and its own modules.
    for name, first in (("PATH", ""), ("PYTHONPATH", str(NODE_FOLDER))):
        entries = [first, *_entries(after, name), *_entries(before, name)]
        after[name] = os.pathsep.join(
            entry for entry in dict.fromkeys(entries) if entry
        )
    return [
        f"export {name}={shlex.quote(after[name])}"
        if name in after
        else f"unset {name}"
        for name in sorted(before.keys() | after.keys())
        if before.get(name) != after.get(name)
    ]


def _entries(variables: Mapping[str, str], name: str) -> list[str]:
    return variables.get(name, "").split(os.pathsep)
