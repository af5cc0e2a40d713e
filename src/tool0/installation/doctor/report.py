"""Runs every probe in a process of its own, all at once, and collects the results.

A probe is a function that takes the machine and returns results.  One that crashes or
hangs affects no other.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from typing import Final, Literal, final

from tool0.installation.child_process import ChildProcess
from tool0.installation.machine import (
    Machine,
    pip_install_command,
    python_package_version,
    python_requirements,
)

PROBES: Final = {
    "machine": "tool0.installation.doctor.probes",
    "python": "tool0.installation.doctor.probes",
    "mujoco": "tool0.api.probes",
    "kernel": "tool0.kernel.probes",
    "panel": "tool0.interfaces.panel.probes",
    "browser": "tool0.interfaces.panel.probes",
    "gpu": "tool0.installation.doctor.probes",
    "cameras": "tool0.engines.mujoco.gl",
    "gazebo": "tool0.installation.doctor.probes",
    "ros1": "tool0.installation.doctor.probes",
    "ros2": "tool0.installation.doctor.probes",
    "ur": "tool0.interfaces.ur.probes",
    "workspace": "tool0.installation.doctor.probes",
}
"""Function → the module that defines it, in the order of the report."""
NEEDED: Final = ("python", "mujoco")
"""Required by ``tool0 bringup``."""
TIMEOUT: Final = 15.0
"""Timeout of all probes together [wall s]."""

_PROGRAM: Final = """\
import sys
sys.path[:] = [entry for entry in sys.path if entry]  # not this folder's mujoco.py
from tool0.installation.doctor.report import run_probe
run_probe(sys.argv[1], sys.argv[2])
"""

ProbeState = Literal["ready", "missing", "not supported", "unknown"]
"""Unknown if the probe failed."""


@final
@dataclass(frozen=True, slots=True)
class ProbeResult:
    """The state of one component of the machine."""

    what: str
    state: ProbeState
    found: str
    """Its version and location, or what is missing and why it is needed."""
    remedy: str = ""
    """The command that installs what is missing; empty if there is none."""


@final
@dataclass(frozen=True, slots=True)
class DoctorReport:
    """What ``tool0 doctor`` prints."""

    lines: tuple[ProbeResult, ...]

    @property
    def can_run(self) -> bool:
        """Whether ``tool0 bringup`` works: the robot in MuJoCo."""
        return all(one.state == "ready" for one in self.lines if one.what in NEEDED)

    def as_json(self) -> dict[str, object]:
        """Return the report for JSON."""
        return {"can_run": self.can_run, "lines": [asdict(one) for one in self.lines]}

    def rows(self) -> list[tuple[str, str, str]]:
        """Return names, states and findings as text."""
        rows: list[tuple[str, str, str]] = []
        for line in self.lines:
            rows.append((line.what, line.state, line.found))
            if line.remedy:
                rows.append(("", "", f"-> {line.remedy}"))
        state, verdict = "ready", "runs here"
        if not self.can_run:
            state = "missing"
            verdict = "does not run here: see python and mujoco above"
        return [*rows, ("tool0 bringup", state, verdict)]


def examine(
    probes: Mapping[str, str] = PROBES, *, timeout: float = TIMEOUT
) -> DoctorReport:
    """Run the probes.

    Args:
        probes: Function → the module that defines it.
        timeout: Timeout of all probes together [wall s].
    """
    deadline = time.monotonic() + timeout
    lines: list[ProbeResult] = []
    with ExitStack() as stack:  # an interrupt ends them all
        started = {
            name: stack.enter_context(
                ChildProcess([sys.executable, "-c", _PROGRAM, module, name])
            )
            for name, module in probes.items()
        }
        for name, process in started.items():
            lines += _results(name, process, deadline)
    return DoctorReport(tuple(lines))


def _results(name: str, process: ChildProcess, deadline: float) -> list[ProbeResult]:
    """Return what a probe found until the deadline, or how it failed."""
    try:
        answer = process.completed(max(deadline - time.monotonic(), 0.0))
    except subprocess.TimeoutExpired:
        return [ProbeResult(name, "unknown", "its probe does not end")]
    try:
        return [ProbeResult(**line) for line in json.loads(answer.stdout)]
    except ValueError:
        errors = answer.stderr.strip().splitlines()
        if answer.returncode < 0:
            reason = signal.Signals(-answer.returncode).name
        else:
            reason = errors[-1] if errors else f"exit status {answer.returncode}"
        return [ProbeResult(name, "unknown", f"its probe failed: {reason}")]


# --- in the process of a probe ---


def run_probe(module: str, function: str) -> None:
    """Print the results of ``function`` of ``module`` as JSON, and exit."""
    from importlib import import_module

    answer = os.dup(1)
    os.dup2(2, 1)  # output of a library is not part of the answer
    try:
        results = getattr(import_module(module), function)(Machine())
    except ImportError as error:
        results = [import_failure(function, error)]
    with os.fdopen(answer, "w", encoding="utf-8") as stream:
        json.dump([asdict(result) for result in results], stream)
    sys.stderr.flush()
    os._exit(0)  # a library's thread or exit handler must not keep us


def import_failure(what: str, error: ImportError) -> ProbeResult:
    """Return the result for something that cannot be imported."""
    package = (error.name or what).partition(".")[0]
    wanted = python_requirements().get(package, package)
    again = [] if python_package_version(package) is None else ["--force-reinstall"]
    return ProbeResult(what, "missing", str(error), pip_install_command(*again, wanted))
