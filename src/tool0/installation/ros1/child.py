"""Programs of ROS that we start: roscore, robot_state_publisher."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import final

from tool0.installation.ros1 import leash


@final
class Child:
    """A program that ends with ``close``, and with this process however that ends."""

    def __init__(self, command: Sequence[str], environment: Mapping[str, str]) -> None:
        """Start it; what it says is kept, for ``last_words``."""
        self.name = Path(command[0]).name
        self._log = tempfile.TemporaryFile()  # noqa: SIM115  # closed with the child
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-S", leash.__file__, *command],
            stdin=subprocess.PIPE,
            stdout=self._log,
            stderr=subprocess.STDOUT,
            env=dict(environment),
            start_new_session=True,
        )

    @property
    def exit_status(self) -> int | None:
        """None while it runs."""
        return self._process.poll()

    def last_words(self) -> str:
        """Return the end of what it said."""
        self._log.seek(0)
        lines = self._log.read().decode(errors="replace").strip().splitlines()
        return "\n".join(f"  {line}" for line in lines[-8:])

    def close(self) -> None:
        """End it, and wait for its end; closing twice is allowed."""
        if self._process.stdin is not None and not self._process.stdin.closed:
            self._process.stdin.close()
            self._process.wait(leash.PATIENCE + 2.0)
        self._log.close()
