"""A robot behind a UR's ports, for tests."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ur_address import free_host
from waits import until

import tool0
from tool0.ur.options import UrOptions
from tool0.ur.process import UrController


@dataclass(frozen=True)
class UrRig:
    """A robot of this process, and the process that presents it as a UR."""

    robot: tool0.Robot
    host: str
    controller: UrController
    programs: Path | None
    """The folder of the dashboard server."""

    def connect(self, port: int) -> socket.socket:
        """Return a connection to one of the ports."""
        return socket.create_connection((self.host, port), timeout=20.0)

    def dashboard(self) -> DashboardLines:
        """Return a connection to the dashboard server, after its greeting."""
        return DashboardLines(self.connect(29999))


@contextmanager
def ur_rig(programs: Path | None = None, **options: Any) -> Iterator[UrRig]:
    """Bring up a robot with its UR interface."""
    host = free_host()
    settings = {"arm": "ur5e", "realtime": True} | options
    with (
        tool0.bringup(**settings) as robot,
        UrController(robot, UrOptions(host=host, programs=programs)) as controller,
    ):
        controller.wait()
        yield UrRig(robot, host, controller, programs)


class DashboardLines:
    """A plain socket client of the dashboard server."""

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self._file = connection.makefile("rw", newline="\n")
        try:
            self.greeting = self.read()
        except OSError:
            self.close()
            raise

    def read(self) -> str:
        """Return the next line; empty at the end."""
        return self._file.readline().removesuffix("\n")

    def ask(self, command: str) -> str:
        """Send a command; return the answer."""
        self.send(command)
        return self.read()

    def send(self, command: str) -> None:
        """Send a command; ``read`` returns the answer."""
        self._file.write(f"{command}\n")
        self._file.flush()

    def until(self, command: str, answer: str) -> None:
        """Ask again until the answer is this one."""
        given = ""

        def is_it() -> bool:
            nonlocal given
            given = self.ask(command)
            return given == answer

        wanted = f"'{answer}' to '{command}'"
        until(is_it, lambda: f"{wanted}, last '{given}'", period=0.0)

    def close(self) -> None:
        """Leave."""
        self._file.close()
        self._connection.close()
