"""The bringup's end of the socket: a thread for the door, one for each visitor.

Nothing here runs in the control tick.  Whatever a peer sends is answered or the
connection ends; the robot only ever sees façade calls with checked parameters.  A
peer that dies is forgotten, and its goals go on, as those of a dead ROS client do.
"""

from __future__ import annotations

import logging
import selectors
import socket
import threading
from typing import final

from tool0.errors import TransportError
from tool0.interfaces.socket.address import Claim
from tool0.interfaces.socket.connection import Connection
from tool0.interfaces.socket.served_robot import ServedRobot

logger = logging.getLogger(__name__)


@final
class RemoteServer:
    """Serves ``robot`` under a claimed name, from construction to ``close``."""

    def __init__(self, robot: ServedRobot, claim: Claim) -> None:
        self._robot = robot
        self._claim = claim
        self._lock = threading.Lock()
        self._connections: set[Connection] = set()
        self._closing = threading.Event()
        self._listener = _listen(claim)
        # socketserver would poll for its end twice a second; a byte wakes at once.
        self._wake, self._waker = socket.socketpair()
        self._thread = threading.Thread(
            target=self._accept, name="tool0-remote", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """Hang up on everyone and remove the socket; closing twice is allowed."""
        with self._lock:
            if self._closing.is_set():
                return
            self._closing.set()
            connections = list(self._connections)
        self._waker.send(b"x")
        self._thread.join()
        self._listener.close()
        for connection in connections:
            connection.close()
        self._wake.close()
        self._waker.close()
        self._claim.close()

    def _accept(self) -> None:
        with selectors.DefaultSelector() as selector:
            selector.register(self._listener, selectors.EVENT_READ)
            selector.register(self._wake, selectors.EVENT_READ)
            while True:
                ready = [key.fileobj for key, _ in selector.select()]
                if self._wake in ready:
                    return
                try:
                    peer, _ = self._listener.accept()
                except OSError as error:  # out of file descriptors, or peer gone
                    logger.warning("cannot accept a connection: %s", error)
                    self._closing.wait(0.1)  # let others return theirs
                    continue
                peer.settimeout(None)  # rospy, for one, changes the default
                self._welcome(peer)

    def _welcome(self, peer: socket.socket) -> None:
        connection = Connection(self._robot, self._claim.name, peer, self._forget)
        with self._lock:
            if self._closing.is_set():
                peer.close()
                return
            self._connections.add(connection)
        threading.Thread(
            target=connection.serve, name="tool0-remote-peer", daemon=True
        ).start()

    def _forget(self, connection: Connection) -> None:
        with self._lock:
            self._connections.discard(connection)


def _listen(claim: Claim) -> socket.socket:
    """Return a listening socket that only this user can open."""
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        # The folder is 0700 already, so nobody can come in before the chmod.
        listener.bind(str(claim.path))
        claim.path.chmod(0o600)
        listener.listen(16)
    except OSError as error:
        listener.close()
        raise TransportError(f"cannot listen on {claim.path}: {error}") from None
    return listener
