"""A bring-up's Unix socket for a test, under its own private folder."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

import tool0
from tool0.protocol.address import Claim
from tool0.protocol.channel import backend_of
from tool0.server.server import Server, UnixSocketService


def use_folder(monkeypatch: pytest.MonkeyPatch, folder: Path) -> Path:
    """Let this test's sockets live below ``folder`` alone; return where."""
    folder.chmod(0o700)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(folder))
    monkeypatch.setenv("TMPDIR", str(folder))
    monkeypatch.setattr("tempfile.tempdir", None)
    return folder / "tool0"


@contextmanager
def serving(robot: tool0.Robot, name: str = "tool0") -> Iterator[Server]:
    """Serve ``robot`` over the Unix socket."""
    service = UnixSocketService(Claim(name))
    with Server(backend_of(robot.channel), [service], name) as server:
        yield server
