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
import tempfile
import time
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from typing import IO, Final, Literal, final

from tool0.installation.child_process import ChildProcess
from tool0.installation.doctor.machine import (
    ExaminedMachine,
    pip_install_command,
    python_package_version,
    python_requirements,
    required_package,
)

PROBES: Final = {
    "machine": "tool0.installation.doctor.system_probes",
    "python": "tool0.installation.doctor.system_probes",
    "mujoco": "tool0.api.probes",
    "panel": "tool0.interfaces.panel.probes",
    "browser": "tool0.interfaces.panel.probes",
    "gpu": "tool0.installation.doctor.system_probes",
    "cameras": "tool0.engines.mujoco.gl",
    "gazebo": "tool0.installation.doctor.ros_probes",
    "ros1": "tool0.installation.doctor.ros_probes",
    "ros2": "tool0.installation.doctor.ros_probes",
    "workspace": "tool0.installation.doctor.ros_probes",
}
"""Function → the module that defines it, in the order of the report."""
NEEDED: Final = ("python", "mujoco")
"""Without which ``tool0 bringup`` does not run."""
TIMEOUT: Final = 15.0
"""For all probes together [wall s]."""

_PROGRAM: Final = """\
import sys
sys.path[:] = [entry for entry in sys.path if entry]  # not this folder's mujoco.py
from tool0.installation.doctor.report import run_probe
run_probe(sys.argv[1], sys.argv[2])
"""
_VERDICT: Final = {
    True: "runs here",
    False: "does not run here: see python and mujoco above",
}

ProbeState = Literal["ready", "missing", "not supported", "unknown"]
"""Unknown if the probe failed."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ProbeResult:
    """The state of one thing that a machine has, or lacks."""

    what: str
    state: ProbeState
    found: str
    """Its version and place; or what is missing, and what for."""
    remedy: str = ""
    """The command that installs what is missing; empty if there is none."""

    def as_json(self) -> dict[str, str]:
        """Return what JSON can hold, by the names of the constructor's arguments."""
        return asdict(self)


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
        """Return what JSON can hold."""
        return {
            "can_run": self.can_run,
            "lines": [line.as_json() for line in self.lines],
        }

    def rows(self) -> list[tuple[str, str, str]]:
        """Return names, states and what was found, for people."""
        rows: list[tuple[str, str, str]] = []
        for line in self.lines:
            rows.append((line.what, line.state, line.found))
            if line.remedy:
                rows.append(("", "", f"-> {line.remedy}"))
        state = "ready" if self.can_run else "missing"
        return [*rows, ("tool0 bringup", state, _VERDICT[self.can_run])]


def examine(
    probes: Mapping[str, str] = PROBES, *, timeout: float = TIMEOUT
) -> DoctorReport:
    """Run the probes.

    Args:
        probes: Function → the module that defines it.
        timeout: For all of them together [wall s].
    """
    deadline = time.monotonic() + timeout
    with ExitStack() as stack:  # an interrupt ends them all
        started = [
            stack.enter_context(_Probe(module, name)) for name, module in probes.items()
        ]
        results = [probe.results(deadline) for probe in started]
    return DoctorReport(tuple(line for lines in results for line in lines))


@final
class _Probe:
    """A probe in a process of its own."""

    def __init__(self, module: str, name: str) -> None:
        self._name = name
        with ExitStack() as stack:
            self._answer = stack.enter_context(tempfile.TemporaryFile())
            self._errors = stack.enter_context(tempfile.TemporaryFile())
            self._process = stack.enter_context(
                ChildProcess(
                    [sys.executable, "-c", _PROGRAM, module, name],
                    stdout=self._answer,
                    stderr=self._errors,
                )
            )
            self._exits = stack.pop_all()

    def __enter__(self) -> _Probe:
        return self

    def __exit__(self, *_: object) -> None:
        self._exits.close()

    def results(self, deadline: float) -> list[ProbeResult]:
        """Return what it found until the deadline, or how it failed."""
        try:
            status = self._process.wait(max(deadline - time.monotonic(), 0.0))
        except subprocess.TimeoutExpired:
            return [self._unknown("its probe does not end")]
        self._answer.seek(0)
        try:
            return [ProbeResult(**line) for line in json.load(self._answer)]
        except ValueError:
            reason = _reason(status, self._errors)
            return [self._unknown(f"its probe failed: {reason}")]

    def _unknown(self, reason: str) -> ProbeResult:
        name = self._name.replace("_", "-")
        return ProbeResult(what=name, state="unknown", found=reason)


def _reason(status: int, errors: IO[bytes]) -> str:
    if status < 0:
        return signal.Signals(-status).name
    errors.seek(0)
    lines = errors.read().decode(errors="replace").strip().splitlines()
    return lines[-1] if lines else f"exit status {status}"


# --- in the process of a probe ---


def run_probe(module: str, function: str) -> None:
    """Print the results of ``function`` of ``module`` as JSON, and exit."""
    from importlib import import_module

    answer = os.dup(1)
    os.dup2(2, 1)  # what a library prints is not part of the answer
    try:
        results = getattr(import_module(module), function)(ExaminedMachine())
    except ImportError as error:
        results = [import_failure(function.replace("_", "-"), error)]
    with os.fdopen(answer, "w", encoding="utf-8") as stream:
        json.dump([result.as_json() for result in results], stream)
    sys.stderr.flush()
    os._exit(0)  # a library's thread or exit handler must not keep us


def import_failure(what: str, error: ImportError) -> ProbeResult:
    """Return the result for something that cannot be imported."""
    package = (error.name or what).partition(".")[0]
    requirements = python_requirements()
    wanted = next((t for t in requirements if required_package(t) == package), package)
    again = [] if python_package_version(package) is None else ["--force-reinstall"]
    return ProbeResult(
        what=what,
        state="missing",
        found=str(error),
        remedy=pip_install_command(*again, wanted),
    )
