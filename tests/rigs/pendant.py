"""The pendant of an e-Series: a dashboard server that may be under local control."""

from __future__ import annotations

import contextlib
import socket
import socketserver
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, final

QUESTION = b"is in remote control\n"


@final
class Pendant:
    """Stands before a dashboard server, and answers one question by itself."""

    def __init__(self, host: str) -> None:
        """Serve the dashboard server of the robot at ``host``."""
        self.is_remote = True
        """Whether the robot is under remote control."""
        self._robot = host, 29999
        pendant = self

        class Lines(socketserver.StreamRequestHandler):
            def handle(self) -> None:
                with contextlib.suppress(OSError):  # the client is gone
                    pendant._serve(self.rfile, self.wfile)

        self._server = socketserver.ThreadingTCPServer(("127.0.0.1", 0), Lines)
        self._server.daemon_threads = True
        self.address: tuple[str, int] = self._server.server_address[:2]  # type: ignore[assignment]  # of IPv4
        """Where it listens."""
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def _serve(self, client: Any, answers: Any) -> None:
        """Pass lines on and answers back; each line has one."""
        with socket.create_connection(self._robot, 20.0) as robot:
            lines = robot.makefile("rb")
            answers.write(lines.readline())  # the greeting
            for line in client:
                if line == QUESTION:
                    answers.write(f"{self.is_remote}\n".lower().encode())
                    continue
                robot.sendall(line)
                answers.write(lines.readline())


@contextmanager
def pendant(host: str) -> Iterator[Pendant]:
    """Serve a pendant until the end of the block."""
    made = Pendant(host)
    try:
        yield made
    finally:
        made.close()
