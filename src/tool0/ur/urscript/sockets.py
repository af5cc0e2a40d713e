"""TCP connections of a program, which is the client of other programs."""

from __future__ import annotations

import asyncio
import ipaddress
from collections.abc import Callable
from typing import TYPE_CHECKING, Final, TypeVar, final

from tool0.errors import ControlError
from tool0.ur.urscript_errors import ValueProblem
from tool0.ur.waiting import within

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox

T = TypeVar("T")

MAX_SOCKETS: Final = 16
OPEN_TIMEOUT: Final = 2.0
"""Maximum time to wait for a connection, or for a peer that does not read [wall s]. The
maximum time is the same as on a real robot."""
MAX_BUFFER: Final = 1 << 16
"""Maximum amount of unread data from a peer [bytes]."""
OWN_GRIPPER: Final = ("127.0.0.1", 63352)
"""Address at which programs expect their gripper; the gripper may use a different
address."""
_LOOPBACK: Final = ipaddress.ip_network("127.0.0.0/8")


@final
class Connection(asyncio.Protocol):
    """A connection; the strings contain one character for each byte."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self._arrived = asyncio.Event()
        """Event that is set when data has been received or the connection has
        changed."""
        self._is_writable = asyncio.Event()
        self._is_writable.set()
        self._transport: asyncio.Transport | None = None

    # ---- asyncio's side -------------------------------------------------------------

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Store the new connection."""
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport

    def data_received(self, data: bytes) -> None:
        """Store received data; stop reading if the program does not use it."""
        self._buffer += data
        if len(self._buffer) > MAX_BUFFER and self._transport is not None:
            self._transport.pause_reading()
        self._arrived.set()

    def pause_writing(self) -> None:
        """Pause sending, because the peer does not read."""
        self._is_writable.clear()

    def resume_writing(self) -> None:
        """Resume sending."""
        self._is_writable.set()

    def connection_lost(self, exc: Exception | None) -> None:
        """End every wait, because the connection has been lost."""
        self._transport = None
        self._arrived.set()
        self._is_writable.set()

    # ---- the program's side ---------------------------------------------------------

    async def send(self, data: bytes) -> bool:
        """Send data and return whether the peer is connected."""
        if self._transport is None or self._transport.is_closing():
            return False
        self._transport.write(data)
        if not self._is_writable.is_set():
            await within(self._is_writable.wait(), OPEN_TIMEOUT)
        return self._transport is not None and self._is_writable.is_set()

    def take(self, find: Callable[[bytearray], T | None]) -> T | None:
        """Find a value in the received bytes, remove its bytes and return it.

        ``find`` must remove the bytes of the value from the buffer. ``find`` returns
        None if the buffer contains no complete value.
        """
        found = find(self._buffer)
        if len(self._buffer) > MAX_BUFFER and found is None:
            self._buffer.clear()
        if self._transport is not None and len(self._buffer) <= MAX_BUFFER:
            self._transport.resume_reading()
        return found

    async def receive(
        self, find: Callable[[bytearray], T | None], timeout: float
    ) -> T | None:
        """Return the value that ``take`` finds as soon as it has been received.

        Args:
            find: Function for ``take``.
            timeout: Maximum time to wait [wall s]; there is no limit if it is 0 or
                less.

        Returns:
            The value, or None after the timeout or if the connection has ended.
        """
        return await within(self._wait_for(find), timeout if timeout > 0.0 else None)

    async def _wait_for(self, find: Callable[[bytearray], T | None]) -> T | None:
        while True:
            found = self.take(find)
            if found is not None or self._transport is None:
                return found
            self._arrived.clear()
            await self._arrived.wait()

    def close(self) -> None:
        """End the connection."""
        if self._transport is not None:
            self._transport.close()


@final
class Sockets:
    """The connections of one run of a program, by name."""

    def __init__(self, box: UrControlBox) -> None:
        """Allow connections to other machines only if the box allows them."""
        self._box = box
        self._connections: dict[str, Connection] = {}

    async def open(self, address: str, port: int, name: str) -> bool:
        """Connect and return whether the connection was opened.

        An open connection with the same name is closed first. An address that is not
        allowed is reported to the clients.

        Raises:
            ValueProblem: If there are too many connections.
        """
        self.close(name)
        if len(self._connections) >= MAX_SOCKETS:
            raise ValueProblem(f"a program has at most {MAX_SOCKETS} sockets")
        host = _numeric(address)
        gripper = self._box.gripper
        if (host, port) == OWN_GRIPPER and gripper and gripper.address:
            host, port = gripper.address
        try:
            self.require_allowed(host)
        except ValueProblem as problem:
            self._box.report(ControlError(str(problem)))
            return False
        # The connection is registered first, so that the end of a program also closes
        # it.
        self._connections[name] = connection = Connection()
        attempt = asyncio.get_running_loop().create_connection(
            lambda: connection, host, port
        )
        try:
            made = await within(attempt, OPEN_TIMEOUT)
        except (OSError, OverflowError, UnicodeError):
            made = None
        if made is None:
            self.close(name)
        return made is not None

    def require_allowed(self, address: str) -> None:
        """Raise ValueProblem for an address to which programs must not connect."""
        if not self._box.allow_sockets and not _is_loopback(_numeric(address)):
            raise ValueProblem(
                f"programs connect to this machine only, not to '{address}'; other "
                "machines need the option --ur-sockets"
            )

    async def answers(self, address: str, port: int) -> bool:
        """Return whether a server accepts connections at an address."""
        attempt = asyncio.open_connection(_numeric(address), port)
        try:
            made = await within(attempt, OPEN_TIMEOUT)
        except (OSError, OverflowError, UnicodeError):
            made = None
        if made is not None:
            made[1].close()
        return made is not None

    def find(self, name: str) -> Connection | None:
        """Return the open connection with this name, or None."""
        return self._connections.get(name)

    def close(self, name: str) -> None:
        """Close a connection if it is open."""
        connection = self._connections.pop(name, None)
        if connection is not None:
            connection.close()

    def close_all(self) -> None:
        """Close all connections."""
        for name in tuple(self._connections):
            self.close(name)


def _numeric(address: str) -> str:
    return "127.0.0.1" if address == "localhost" else address


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host) in _LOOPBACK
    except ValueError:
        return False
