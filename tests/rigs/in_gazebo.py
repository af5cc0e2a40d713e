"""What the tests on real gzserver share."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

import tool0
from tool0.engines.gazebo.engine import GazeboEngine
from tool0.installation.gazebo.installation import find_installation

PATIENCE = 60.0
"""For what takes a moment on a busy machine [wall s]."""


class BringUp(Protocol):
    """Bring a robot up in Gazebo, as ``tool0.bringup`` does."""

    def __call__(self, **options: object) -> tuple[tool0.Robot, GazeboEngine]: ...


def gz(engine: GazeboEngine, *arguments: str) -> str:
    """Run Gazebo's own command on the engine's server; return what it prints."""
    found = find_installation()
    program = found.server.with_name(found.server.name.replace("gzserver", "gz"))
    for _ in range(5):
        answer = subprocess.run(
            [str(program), *arguments],
            env={
                **os.environ,
                **found.environment,
                "HOME": str(engine.server.folder),
                "GAZEBO_MASTER_URI": engine.server.master_uri,
                "GAZEBO_IP": "127.0.0.1",
            },
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
        if answer.returncode == 0:
            return answer.stdout
        # Its threads outlive what they use: now and then it aborts at its end.
        assert answer.returncode < 0, answer
    raise AssertionError(f"gz {arguments} always aborts")


def gazebo_with(**options: object) -> tool0.SimulationConfig:
    """Return Gazebo with options of its own."""
    return tool0.SimulationConfig(engine="gazebo", engine_options=options)


_PROGRAM = """
import sys, tool0
options = {"gui": "gui" in sys.argv}
robot = tool0.bringup(
    simulation=tool0.SimulationConfig(engine="gazebo", engine_options=options)
)
print(robot.engine.server.folder, flush=True)
input()
"""


@contextmanager
def process_with_a_robot(*words: str) -> Iterator[tuple[subprocess.Popen[str], Path]]:
    """Bring a robot up in a process of its own, with ``gui`` in Gazebo's window, too.

    Yields the process and the folder of its gzserver.  Who asks ends the process.
    """
    with subprocess.Popen(
        [sys.executable, "-c", _PROGRAM, *words],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        yield process, Path(process.stdout.readline().strip())
