"""TCP connections of a program, as clients of other programs."""

from __future__ import annotations

import asyncio
import ipaddress
from collections.abc import Callable, Coroutine
from typing import TYPE_CHECKING, Any, Final, TypeVar, final

from tool0.errors import ControlError
from tool0.ur.urscript_errors import ValueProblem

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox

T = TypeVar("T")

MAX_SOCKETS: Final = 16
OPEN_TIMEOUT: Final = 2.0
"""For a connection, and for a peer that does not read [wall s]; as on the robot."""
MAX_BUFFER: Final = 1 << 16
"""Most data of a peer that is kept unread [bytes]."""
OWN_GRIPPER: Final = ("127.0.0.1", 63352)
"""Where a program finds its gripper, which may listen at another address."""
_CHUNK: Final = 4096
_LOOPBACK: Final = ipaddress.ip_network("127.0.0.0/8")


@final
class Connection:
    """One connection; strings have one character for each byte."""

    def __init__(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        self._reader = reader
        self._writer = writer
        self._buffer = bytearray()

    async def send(self, data: bytes) -> bool:
        """Send and return whether the peer is there."""
        if self._writer.transport.is_closing():
            return False
        try:
            self._writer.write(data)
            return await _within(_drained(self._writer), OPEN_TIMEOUT) is not None
        except OSError:
            return False

    async def receive(
        self, find: Callable[[bytearray], T | None], timeout: float
    ) -> T | None:
        """Return what is found in the bytes received, and take it out.

        Args:
            find: Removes what it returns from the buffer; None to wait for more.
            timeout: Longest wait [wall s]; no limit if 0 or less.

        Returns:
            None after the timeout, or if the connection has ended.
        """
        try:
            return await _within(
                self._receive(find), timeout if timeout > 0.0 else None
            )
        except OSError:
            return None

    async def _receive(self, find: Callable[[bytearray], T | None]) -> T | None:
        while True:
            found = find(self._buffer)
            if found is not None:
                return found
            if len(self._buffer) > MAX_BUFFER:
                self._buffer.clear()
            data = await self._reader.read(_CHUNK)
            if not data:
                return None
            self._buffer += data

    def close(self) -> None:
        """End the connection."""
        self._writer.close()


@final
class Sockets:
    """The connections of one run of a program, by name."""

    def __init__(self, box: UrControlBox) -> None:
        """Connect to this machine only, unless the box allows others."""
        self._box = box
        self._connections: dict[str, Connection] = {}

    async def open(self, address: str, port: int, name: str) -> bool:
        """Connect, and return whether it worked.  A name in use is closed first.

        Clients are told if the address is not allowed.

        Raises:
            ValueProblem: There are too many.
        """
        self.close(name)
        if len(self._connections) >= MAX_SOCKETS:
            raise ValueProblem(f"a program has at most {MAX_SOCKETS} sockets")
        host = "127.0.0.1" if address == "localhost" else address
        gripper = self._box.gripper
        if (host, port) == OWN_GRIPPER and gripper and gripper.address:
            host, port = gripper.address
        if not self._box.allow_sockets and not _is_loopback(host):
            self._box.report(
                ControlError(
                    f"programs connect to this machine only, not to '{address}'; other "
                    "machines need the option --ur-sockets"
                )
            )
            return False
        try:
            streams = await _within(
                asyncio.open_connection(host, port, limit=_CHUNK), OPEN_TIMEOUT
            )
        except (OSError, OverflowError, UnicodeError):
            return False
        if streams is None:
            return False
        self._connections[name] = Connection(*streams)
        return True

    def find(self, name: str) -> Connection | None:
        """Return an open connection."""
        return self._connections.get(name)

    def close(self, name: str) -> None:
        """Close a connection, if it is open."""
        connection = self._connections.pop(name, None)
        if connection is not None:
            connection.close()

    def close_all(self) -> None:
        """Close all connections."""
        for name in tuple(self._connections):
            self.close(name)


async def _within(action: Coroutine[Any, Any, T], timeout: float | None) -> T | None:
    """Return the result of an action; None if it is not done in time [wall s].

    Whoever waits here can be cancelled at any moment.  Before Python 3.12,
    asyncio.wait_for drops a cancellation that comes together with the result.
    """
    task = asyncio.ensure_future(action)
    try:
        await asyncio.wait({task}, timeout=timeout)
    finally:
        if not task.done():
            task.cancel()
    return task.result() if task.done() else None


async def _drained(writer: asyncio.StreamWriter) -> bool:
    await writer.drain()
    return True


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host) in _LOOPBACK
    except ValueError:
        return False
