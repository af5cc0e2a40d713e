"""A client of a Modbus unit that sends one request at a time."""

from __future__ import annotations

import asyncio
import errno
from typing import Final, final

from tool0.devices.modbus_frames import ERROR, HEADER, MAX_LENGTH
from tool0.ur.waiting import within

TIMEOUT: Final = 2.0
"""Maximum time to wait for a connection or a response [wall s]."""
DISCONNECTED: Final = -2
"""Error code for a missing connection."""


@final
class DeviceError(Exception):
    """Raised if a unit refuses a request; the code is a Modbus exception code."""

    def __init__(self, code: int) -> None:
        self.code = code


@final
class ConnectionProblem(Exception):  # noqa: N818 - a state that programs query
    """Raised if a unit does not respond; the code is an errno or ``DISCONNECTED``."""

    def __init__(self, code: int) -> None:
        self.code = code


@final
class ModbusClient:
    """A client of one address, which connects when it sends a request."""

    def __init__(self, host: str, port: int) -> None:
        self._address = host, port
        self._streams: tuple[asyncio.StreamReader, asyncio.StreamWriter] | None = None
        self._turn = asyncio.Lock()
        self._transaction = 0

    async def request(self, unit: int, function: int, data: bytes) -> bytes:
        """Return the data in the response to a request.

        Raises:
            DeviceError: If the unit refuses the request.
            ConnectionProblem: If there is no response.
        """
        async with self._turn:
            try:
                response = await within(self._exchange(unit, function, data), TIMEOUT)
            except (OSError, asyncio.IncompleteReadError) as error:
                self.close()
                code = error.errno if isinstance(error, OSError) else None
                raise ConnectionProblem(code or DISCONNECTED) from None
            except BaseException:
                self.close()  # a late answer must not be read as the next response
                raise
            if response is None:
                self.close()
                raise ConnectionProblem(errno.ETIMEDOUT)
        if response[0] == function | ERROR and len(response) > 1:
            raise DeviceError(response[1])
        if response[0] != function:
            self.close()
            raise ConnectionProblem(errno.EPROTO)
        return response[1:]

    def close(self) -> None:
        """End the connection."""
        streams, self._streams = self._streams, None
        if streams is not None:
            streams[1].transport.abort()

    async def _exchange(self, unit: int, function: int, data: bytes) -> bytes:
        if self._streams is None or self._streams[0].at_eof():
            self.close()
            self._streams = await asyncio.open_connection(*self._address)
        reader, writer = self._streams
        self._transaction = self._transaction + 1 & 0xFFFF
        header = HEADER.pack(self._transaction, 0, len(data) + 2, unit)
        writer.write(header + bytes([function]) + data)
        found, protocol, length, _ = HEADER.unpack(
            await reader.readexactly(HEADER.size)
        )
        if (found, protocol) != (self._transaction, 0) or not 2 <= length <= MAX_LENGTH:
            raise OSError(errno.EPROTO, "not a response to the request")
        return await reader.readexactly(length - 1)
