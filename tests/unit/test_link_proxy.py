"""The network that fails, of the tests of a real robot, fails as it says."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator

import pytest
from link_proxy import End, LinkProxy, link_proxy

DELAY = 0.05
"""[wall s]"""


class Ends:
    """A connection through a proxy, and both its ends."""

    def __init__(self) -> None:
        self.listener = socket.create_server(("127.0.0.1", 0))
        with socket.create_server(("127.0.0.1", 0)) as probe:
            near = probe.getsockname()
        self.proxy_context = link_proxy({near: self.listener.getsockname()})
        self.proxy: LinkProxy = self.proxy_context.__enter__()
        self.near = near
        self.client = self.connect()
        self.server, _ = self.listener.accept()
        self.server.settimeout(10.0)
        self.passage(b"?")  # the proxy knows both ends then

    def connect(self) -> socket.socket:
        client = socket.create_connection(self.near, 10.0)
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return client

    def close(self) -> None:
        self.client.close()
        self.server.close()
        self.listener.close()
        self.proxy_context.__exit__(None, None, None)

    def passage(self, data: bytes) -> float:
        """Send from the client to the server; return how long it took [wall s]."""
        start = time.perf_counter()
        self.client.sendall(data)
        assert read(self.server, len(data)) == data
        return time.perf_counter() - start


@pytest.fixture
def ends() -> Iterator[Ends]:
    made = Ends()
    yield made
    made.close()


def read(one: socket.socket, count: int) -> bytes:
    data = b""
    while len(data) < count and (more := one.recv(count - len(data))):
        data += more
    return data


def test_it_forwards_both_ways(ends: Ends) -> None:
    ends.client.sendall(b"there")
    ends.server.sendall(b"back")
    assert (read(ends.server, 5), read(ends.client, 4)) == (b"there", b"back")


def test_a_delay_holds_each_chunk_up(ends: Ends) -> None:
    ends.proxy.delay = DELAY
    assert ends.passage(b"late") >= DELAY


def test_jitter_keeps_the_order(ends: Ends) -> None:
    ends.proxy.jitter = DELAY
    numbers = bytes(range(50))
    for number in numbers:
        ends.client.sendall(bytes([number]))
    assert read(ends.server, len(numbers)) == numbers


def test_a_lost_segment_comes_after_a_retransmission(ends: Ends) -> None:
    ends.proxy.loss = 1.0
    assert ends.passage(b"again") >= DELAY


def test_a_throttled_link_delivers_at_its_rate(ends: Ends) -> None:
    ends.proxy.rate = 100e3
    assert ends.passage(bytes(10_000)) >= 0.1


def test_a_pulled_cable_delivers_later(ends: Ends) -> None:
    ends.proxy.hold()
    ends.client.sendall(b"held")
    ends.server.settimeout(DELAY)
    with pytest.raises(TimeoutError):
        ends.server.recv(4)
    ends.server.settimeout(10.0)
    ends.proxy.release()
    assert read(ends.server, 4) == b"held"


def test_a_half_closed_connection_still_works_the_other_way(ends: Ends) -> None:
    ends.proxy.half_close(End.SERVER)
    assert ends.server.recv(1) == b""
    ends.client.sendall(b"lost")
    ends.server.sendall(b"answer")
    assert read(ends.client, 6) == b"answer"
    ends.server.close()
    assert ends.client.recv(1) == b""


def test_an_end_that_closes_is_noticed_at_the_other_one(ends: Ends) -> None:
    ends.client.close()
    assert ends.server.recv(1) == b""


def test_a_cut_resets_connections_until_it_is_mended(ends: Ends) -> None:
    ends.proxy.cut()
    with pytest.raises(ConnectionResetError):
        ends.server.recv(1)
    with pytest.raises(ConnectionResetError), ends.connect() as refused:
        refused.recv(1)
    ends.proxy.mend()
    with ends.connect() as client:
        client.sendall(b"again")
        server, _ = ends.listener.accept()
        with server:
            server.settimeout(10.0)
            assert read(server, 5) == b"again"
