"""Sends URScript to a robot's controller, by its primary interface."""

from __future__ import annotations

import socket
from typing import Final

from tool0.errors import TransportError

PORT: Final = 30001


def send_script(host: str, text: str, port: int = PORT, timeout: float = 2.0) -> None:
    """Send a program; the controller starts it in place of the one that runs.

    A ``sec`` program runs beside it.  Whether it started shows in RTDE.

    Raises:
        TransportError: If the controller is not there.
    """
    try:
        with socket.create_connection((host, port), timeout) as connection:
            connection.sendall(text.encode() + b"\n")
            connection.shutdown(socket.SHUT_WR)
            # The controller reads until the end; its own packets do not matter here.
            connection.settimeout(timeout)
            connection.recv(1)
    except OSError as error:
        raise TransportError(
            f"cannot send a program to {host}:{port}: {error}"
        ) from None
