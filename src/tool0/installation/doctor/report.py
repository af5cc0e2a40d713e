"""Runs all probes in parallel, in separate processes, and collects their results.

The command line defines the list of probes.  A probe that crashes or hangs does not
affect other probes.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from typing import Final, Literal, TypedDict, final

from tool0.installation.child_process import ChildProcess
from tool0.installation.machine import (
    Machine,
    pip_install_command,
    python_package_version,
    python_requirements,
)

TIMEOUT: Final = 15.0
"""Time limit for all probes together [wall s]."""

_PROGRAM: Final = """\
import sys
sys.path[:] = [entry for entry in sys.path if entry]  # not this folder's mujoco.py
from tool0.installation.doctor.report import run_probe
run_probe(sys.argv[1], sys.argv[2])
"""

ProbeState = Literal["ready", "missing", "not supported", "unknown"]
"""State of a component.  The state is ``unknown`` if the probe failed."""


@final
@dataclass(frozen=True, slots=True)
class ProbeResult:
    """The state of one component of the machine."""

    what: str
    """Name of the component."""
    state: ProbeState
    """State of the component."""
    found: str
    """Version and location of the component.  If the component is missing, the text
    states which part is missing and why it is needed."""
    remedy: str = ""
    """The command that installs the missing parts; empty if no command can install
    them."""


@final
@dataclass(frozen=True, slots=True)
class Probe:
    """A function that examines one component of the machine."""

    examine: Callable[[Machine], list[ProbeResult]]
    """Function in a module.  A separate process imports the function by name and runs
    it."""
    is_needed: bool = False
    """Whether ``tool0 bringup`` requires the component."""

    @property
    def name(self) -> str:
        """Name of the function.

        The result of a required component has the same name as the function.
        """
        return self.examine.__name__


class DoctorJson(TypedDict):
    """The report as data for JSON."""

    can_run: bool
    """Whether ``tool0 bringup`` works on this machine."""
    lines: tuple[ProbeResult, ...]
    """The examined components."""


@final
@dataclass(frozen=True, slots=True)
class DoctorReport:
    """The result of ``tool0 doctor``."""

    lines: tuple[ProbeResult, ...]
    needed: tuple[str, ...]
    """The components that ``tool0 bringup`` requires."""

    @property
    def can_run(self) -> bool:
        """Whether ``tool0 bringup`` works on this machine."""
        needed = (line for line in self.lines if line.what in self.needed)
        return all(line.state == "ready" for line in needed)

    def as_json(self) -> DoctorJson:
        """Return the report as data for JSON."""
        return {"can_run": self.can_run, "lines": self.lines}

    def rows(self) -> list[tuple[str, str, str]]:
        """Return the names, states and findings of the components as text."""
        rows: list[tuple[str, str, str]] = []
        for line in self.lines:
            rows.append((line.what, line.state, line.found))
            if line.remedy:
                rows.append(("", "", f"-> {line.remedy}"))
        state, verdict = "ready", "runs here"
        if not self.can_run:
            state = "missing"
            verdict = f"does not run here: see {' and '.join(self.needed)} above"
        return [*rows, ("tool0 bringup", state, verdict)]


def examine(probes: Sequence[Probe], *, timeout: float = TIMEOUT) -> DoctorReport:
    """Run the probes.

    Args:
        probes: The probes, in the order in which they are reported.
        timeout: Time limit for all probes together [wall s].
    """
    deadline = time.monotonic() + timeout
    lines: list[ProbeResult] = []
    with ExitStack() as stack:  # an interrupt ends all processes
        started = [stack.enter_context(_start(probe)) for probe in probes]
        for probe, process in zip(probes, started, strict=True):
            lines += _results(probe.name, process, deadline)
    needed = tuple(probe.name for probe in probes if probe.is_needed)
    return DoctorReport(tuple(lines), needed)


def _start(probe: Probe) -> ChildProcess:
    module = probe.examine.__module__
    return ChildProcess([sys.executable, "-c", _PROGRAM, module, probe.name])


def _results(name: str, process: ChildProcess, deadline: float) -> list[ProbeResult]:
    """Return the results of a probe, or a failure if the probe misses the deadline."""
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
    """Print the results of ``function`` in ``module`` as JSON, and exit."""
    from importlib import import_module

    answer = os.dup(1)
    os.dup2(2, 1)  # the output of libraries must not be mixed with the results
    try:
        results = getattr(import_module(module), function)(Machine())
    except ImportError as error:
        results = [import_failure(function, error)]
    with os.fdopen(answer, "w", encoding="utf-8") as stream:
        json.dump([asdict(result) for result in results], stream)
    sys.stderr.flush()
    os._exit(0)  # threads and exit handlers of libraries must not delay the exit


def import_failure(what: str, error: ImportError) -> ProbeResult:
    """Return the result for a component that cannot be imported."""
    package = (error.name or what).partition(".")[0]
    wanted = python_requirements().get(package, package)
    again = [] if python_package_version(package) is None else ["--force-reinstall"]
    return ProbeResult(what, "missing", str(error), pip_install_command(*again, wanted))
