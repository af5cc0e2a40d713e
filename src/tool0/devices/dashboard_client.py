"""A client of UR's dashboard server; each command and each answer is one line.

The commands and answers follow UR's documentation; see ``ur/dashboard.py``.
"""

from __future__ import annotations

import contextlib
import select
import socket
import threading
from typing import Final, final

from tool0.errors import ControlError, TransportError

PORT: Final = 29999
_MOST_ANSWER: Final = 1 << 16


@final
class DashboardClient:
    """Sends commands to a dashboard server from any thread; connects when necessary."""

    def __init__(self, host: str, port: int = PORT, timeout: float = 5.0) -> None:
        """Prepare a client; ``timeout`` is the maximum wait for an answer [s]."""
        self._address, self._timeout = (host, port), timeout
        self._lock = threading.Lock()
        self._socket: socket.socket | None = None
        self._received = bytearray()

    def ask(self, command: str) -> str:
        """Send a command and return the answer.

        Raises:
            TransportError: If the server cannot be reached, or does not answer within
                the timeout.
        """
        with self._lock:
            try:
                if self._socket is not None and self._has_ended():
                    self._drop()
                if self._socket is None:
                    self._connect()
                assert self._socket is not None
                self._socket.sendall(f"{command}\n".encode())
                return self._line()
            except OSError as error:
                self._drop()
                host, port = self._address
                raise TransportError(
                    f"the dashboard server {host}:{port} does not answer "
                    f"'{command}': {error or 'it closed the connection'}"
                ) from None

    def order(self, command: str, accepted: str) -> None:
        """Send a command; the answer starts with ``accepted`` if the robot executes it.

        Raises:
            ControlError: If the robot refuses the command; the message contains the
                answer.
            TransportError: See ``ask``.
        """
        answer = self.ask(command)
        if not answer.lower().startswith(accepted.lower()):
            raise ControlError(f"the robot refuses '{command}': {answer}")

    def find(self, command: str) -> str:
        """Return the answer to a command; empty if the command is not supported."""
        answer = self.ask(command)
        unknown = ("could not understand", "error")
        return "" if answer.lower().startswith(unknown) else answer

    @property
    def is_in_remote_control(self) -> bool | None:
        """Whether the robot is in remote control; None if it has no such mode (CB3)."""
        answer = self.find("is in remote control").lower()
        return answer == "true" if answer in {"true", "false"} else None

    def close(self) -> None:
        """End the connection."""
        with self._lock:
            self._drop()

    def _connect(self) -> None:
        self._socket = socket.create_connection(self._address, self._timeout)
        self._received.clear()
        self._line()  # the greeting

    def _has_ended(self) -> bool:
        """Return whether the server has closed the connection since the last answer."""
        assert self._socket is not None
        return bool(select.select([self._socket], [], [], 0.0)[0])  # unsolicited

    def _line(self) -> str:
        assert self._socket is not None
        while (end := self._received.find(b"\n")) < 0:
            data = self._socket.recv(4096)
            if not data or len(self._received) > _MOST_ANSWER:
                raise ConnectionResetError("it closed the connection")
            self._received += data
        line = self._received[:end].decode(errors="replace").strip()
        del self._received[: end + 1]
        return line

    def _drop(self) -> None:
        connection, self._socket = self._socket, None
        if connection is not None:
            with contextlib.suppress(OSError):
                connection.close()
