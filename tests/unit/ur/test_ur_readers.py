"""Clients that do not read what they are sent."""

import asyncio
import socket

from ur_address import free_host

from tool0.ur.client_interface.interface import MAX_BEHIND, send_to_readers
from tool0.ur.listening import Port

PACKET = b"".join(k.to_bytes(2, "big") for k in range(610))


def test_who_does_not_read_misses_whole_packets_and_stays_connected():
    async def scenario() -> int:
        async def serve(peer):
            await peer.reader.read()

        port = Port("test", serve)
        await port.listen(free_host(), 0)
        host = next(iter(port._server.sockets)).getsockname()
        client = socket.create_connection(host)
        while not port.peers:
            await asyncio.sleep(0)
        (peer,) = port.peers
        for _ in range(20_000):  # 24 MB
            send_to_readers([peer], PACKET)
            assert peer.owed < MAX_BEHIND + len(PACKET)
        client.setblocking(False)
        received = b""
        while peer.owed or len(received) % len(PACKET) or not received:
            try:
                received += client.recv(1 << 20)
            except BlockingIOError:
                await asyncio.sleep(0)
        assert received == PACKET * (len(received) // len(PACKET))
        assert port.peers == {peer}
        client.close()
        await port.close()
        return len(received)

    assert 0 < asyncio.run(scenario()) < 20_000 * len(PACKET)
