"""Runs every probe in a process of its own, all at once, and gathers what they say."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import IO, Final, final

from tool0.installation.doctor.line import Line
from tool0.installation.doctor.probes import NEEDED, PROBES

PATIENCE: Final = 15.0
"""Wall seconds for all of them; one that has found nothing by then hangs."""
_GRACE: Final = 5.0
"""Wall seconds after which a process ends of itself, should nobody have ended it."""
_PROGRAM: Final = """\
import sys
sys.path[:] = [entry for entry in sys.path if entry]  # not this folder's mujoco.py
from tool0.installation.doctor.child import main
main(sys.argv[1], sys.argv[2], float(sys.argv[3]))
"""


_VERDICT: Final = {
    True: "runs here",
    False: "does not run here: see python and mujoco above",
}


@final
@dataclass(frozen=True, slots=True)
class Report:
    """What ``tool0 doctor`` tells."""

    lines: tuple[Line, ...]

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
        can = "ready" if self.can_run else "missing"
        return [*rows, ("tool0 bringup", can, _VERDICT[self.can_run])]


def examine(
    probes: Mapping[str, str] = PROBES, *, patience: float = PATIENCE
) -> Report:
    """Look at everything.

    Args:
        probes: Function → the module that has it.
        patience: Wall seconds for all of them together.
    """
    # Should we be interrupted, the leash goes first: then no thread waits long.
    with ThreadPoolExecutor(max(len(probes), 1)) as pool, _leash() as leash:
        found = pool.map(
            lambda name: _look(leash, probes[name], name, patience), probes
        )
        return Report(tuple(line for lines in found for line in lines))


@contextlib.contextmanager
def _leash() -> Iterator[int]:
    """Open what every process reads from; it closes when we end, however we do."""
    theirs, ours = os.pipe()
    try:
        yield theirs
    finally:
        os.close(theirs)
        os.close(ours)


def _look(leash: int, module: str, name: str, patience: float) -> list[Line]:
    """Return what a probe says, or what became of it; then nothing of it runs."""
    # What it says is a file: a pipe would be held open by whom it left behind.
    with (
        tempfile.TemporaryFile() as said,
        subprocess.Popen(
            [sys.executable, "-c", _PROGRAM, module, name, str(patience + _GRACE)],
            stdin=leash,
            stdout=subprocess.PIPE,
            stderr=said,
            start_new_session=True,
        ) as child,
    ):
        try:
            answer, _ = child.communicate(timeout=patience)
            return [Line(**line) for line in json.loads(answer)]
        except subprocess.TimeoutExpired:
            return [_unknown(name, "its probe does not end")]
        except ValueError:
            said.seek(0)
            return [_unknown(name, f"its probe broke off: {_reason(child, said)}")]
        finally:
            _end(child)


def _end(child: subprocess.Popen[bytes]) -> None:
    """End it and whom it started."""
    if sys.platform == "win32":
        child.kill()
    else:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child.pid, signal.SIGKILL)


def _reason(child: subprocess.Popen[bytes], said: IO[bytes]) -> str:
    if child.returncode < 0:
        return signal.Signals(-child.returncode).name
    words = said.read().decode(errors="replace").strip().splitlines()
    return words[-1] if words else f"exit status {child.returncode}"


def _unknown(name: str, why: str) -> Line:
    return Line(what=name.replace("_", "-"), state="unknown", found=why)
