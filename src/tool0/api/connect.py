"""``tool0.connect``: a robot that runs in another process."""

from __future__ import annotations

from tool0.api.robot import Robot
from tool0.protocol.address import DEFAULT_NAME
from tool0.protocol.socket_channel import SocketChannel


def connect(name: str = DEFAULT_NAME) -> Robot:
    """Return a robot that runs in another process of this user.

    The robot has the same methods as a robot from ``tool0.bringup``; ``close`` ends
    only the connection.  Timeouts are in wall seconds.

    Args:
        name: The ``--name`` of the bring-up.

    Raises:
        TransportError: If no bring-up with this name is running.
    """
    return Robot(SocketChannel(name))
