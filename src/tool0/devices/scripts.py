"""Transmission of URScript to a robot's controller over its primary interface."""

from __future__ import annotations

import socket
from typing import Final

from tool0.errors import TransportError

PORT: Final = 30001


def send_script(host: str, text: str, port: int = PORT, timeout: float = 2.0) -> None:
    """Send a program, which replaces the running program.

    A ``sec`` program runs alongside the current program. Use RTDE to check whether the
    program has started.

    Raises:
        TransportError: If the controller cannot be reached.
    """
    try:
        with socket.create_connection((host, port), timeout) as connection:
            connection.sendall(text.encode() + b"\n")
            connection.shutdown(socket.SHUT_WR)
            # The controller reads until the end of the data. The packets that it sends
            # are ignored.
            connection.settimeout(timeout)
            connection.recv(1)
    except OSError as error:
        raise TransportError(
            f"cannot send a program to {host}:{port}: {error}"
        ) from None
