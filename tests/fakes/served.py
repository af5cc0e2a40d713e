"""A bringup of a fake robot for a test, under its own private socket folder."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from fake_robot import FakeRobot
from tool0.interfaces.socket.server import RemoteServer

from tool0.api.address import Claim


def use_folder(monkeypatch: pytest.MonkeyPatch, folder: Path) -> Path:
    """Let this test's sockets live below ``folder`` alone; return where."""
    folder.chmod(0o700)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(folder))
    monkeypatch.setenv("TMPDIR", str(folder))
    monkeypatch.setattr("tempfile.tempdir", None)
    return folder / "tool0"


@contextmanager
def serving(robot: FakeRobot, name: str = "tool0") -> Iterator[RemoteServer]:
    server = RemoteServer(robot, Claim(name))
    try:
        yield server
    finally:
        server.close()
