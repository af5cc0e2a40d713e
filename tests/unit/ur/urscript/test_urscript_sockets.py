"""Sockets of programs: what arrives is never waited for."""

from __future__ import annotations

import asyncio
import socket

import pytest

from tool0.ur.urscript.sockets import Connection


def one_byte(buffer: bytearray) -> bytes | None:
    return bytes([buffer.pop(0)]) if buffer else None


@pytest.mark.parametrize("turns", range(4))
def test_data_that_arrive_as_the_wait_begins_are_found(turns: int) -> None:
    async def received() -> bytes | None:
        with socket.create_server(("127.0.0.1", 0)) as server:
            connection = Connection()
            await asyncio.get_running_loop().create_connection(
                lambda: connection, *server.getsockname()
            )
            reading = asyncio.ensure_future(connection.receive(one_byte, 0.0))
            for _ in range(turns):
                await asyncio.sleep(0)
            connection.data_received(b"x")
            try:
                return await asyncio.wait_for(reading, 5.0)
            finally:
                connection.close()

    assert asyncio.run(received()) == b"x"
