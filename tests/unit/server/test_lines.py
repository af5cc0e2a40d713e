"""Lines of the Unix socket, over a pair of sockets."""

from __future__ import annotations

import asyncio
import contextlib
import socket

import pytest

from tool0.errors import TransportError
from tool0.server import lines as lines_module
from tool0.server.budget import Budget
from tool0.server.lines import LineTransport

LONG = 30.0  # [wall s]; only a failing test waits so long


async def connected() -> tuple[LineTransport, socket.socket]:
    ours, theirs = socket.socketpair()
    for end in (ours, theirs):
        end.setblocking(False)
    lines = LineTransport(Budget().account())
    await asyncio.get_running_loop().connect_accepted_socket(lambda: lines, ours)
    return lines, theirs


def test_lines_arrive_whole_however_they_were_sent() -> None:
    async def scenario() -> list[bytes]:
        lines, theirs = await connected()
        sent = [b"x" * n for n in (1, 100_000, 3, 300_000)]
        loop = asyncio.get_running_loop()
        sending = loop.create_task(
            loop.sock_sendall(theirs, b"\n".join((*sent, b"rest without an end")))
        )
        found = []
        while len(found) < len(sent):
            text = await asyncio.wait_for(lines.receive(), LONG)
            assert text is not None
            found.append(text)
        await sending
        theirs.close()
        assert await asyncio.wait_for(lines.receive(), LONG) is None
        await lines.close()
        assert found == sent
        return found

    asyncio.run(scenario())


def test_nothing_is_read_that_nobody_takes() -> None:
    """The peer's socket fills up: what is kept of it has a bound."""

    async def scenario() -> None:
        lines, theirs = await connected()
        block = b"{}\n" * 10_000 + b"\n \n"  # empty lines are none
        n_sent = 0
        n_idle = 0
        while n_idle < 100:
            try:
                n_sent += theirs.send(block)
                n_idle = 0
            except BlockingIOError:
                n_idle += 1
            await asyncio.sleep(0)
        kept = len(lines._buffer)
        assert kept <= 3 * lines_module._CHUNK
        for _ in range(kept // 4):
            assert await asyncio.wait_for(lines.receive(), LONG) == b"{}"
        theirs.close()
        await lines.close()

    asyncio.run(scenario())


def test_a_line_that_never_ends_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lines_module, "MAX_LINE", 200_000)

    async def scenario() -> None:
        lines, theirs = await connected()
        loop = asyncio.get_running_loop()
        sending = loop.create_task(loop.sock_sendall(theirs, b"x" * 400_000))

        with pytest.raises(TransportError):
            await asyncio.wait_for(lines.receive(), LONG)
        sending.cancel()
        await asyncio.gather(sending, return_exceptions=True)
        theirs.close()
        await lines.close()

    asyncio.run(scenario())


def test_a_burst_to_a_peer_that_is_gone_ends_at_the_first_failure(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async def scenario() -> None:
        lines, peer = await connected()
        peer.close()
        for _ in range(20):  # the event loop does not run in between
            with contextlib.suppress(ConnectionResetError):
                await lines.send([b"{}"])
        await lines.closed()

    asyncio.run(scenario())
    assert caplog.records == []
