"""A network that fails, between tool0 and a robot: TCP proxies in a thread.

A lost segment of TCP delays all that follows it: here by ``RECOVERY``, a fast
retransmission (one round trip and the three packets after it), since streams of this
rate never wait for a timeout.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import random
import socket
import struct
import threading
import weakref
from collections.abc import Coroutine, Iterator, Mapping
from contextlib import contextmanager
from enum import Enum
from typing import Any, Final, final

RECOVERY: Final = 0.055
"""[wall s]"""
_CHUNK: Final = 1 << 16

Address = tuple[str, int]


class End(Enum):
    """An end of a connection."""

    CLIENT = "client"
    """Which has opened it."""
    SERVER = "server"


@final
class LinkProxy:
    """Forwards ports, with faults that may change at any time."""

    def __init__(self, routes: Mapping[Address, Address], seed: int = 0) -> None:
        """Listen at each address, and forward to the other one."""
        self.delay = 0.0
        """Each chunk is late by this [wall s] …"""
        self.jitter = 0.0
        """… and by a random time up to this, in order."""
        self.rate = math.inf
        """Each direction of a connection delivers at most that much [byte/s]."""
        self.loss = 0.0
        """Part of the chunks that are lost at first."""
        self._random = random.Random(seed)
        self._routes = routes
        self._loop = asyncio.new_event_loop()
        self._flows = asyncio.Event()
        self._flows.set()
        self._refused: set[int] = set()
        """Ports that accept no connections."""
        self._writers: dict[asyncio.StreamWriter, tuple[End, int]] = {}
        """With their end, and the port of the proxy."""
        self._half_closed = weakref.WeakSet[asyncio.StreamWriter]()
        self._servers: list[asyncio.Server] = []
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self._run(self._listen())

    def hold(self) -> None:
        """Deliver nothing in either direction, as with a pulled cable."""
        self._loop.call_soon_threadsafe(self._flows.clear)

    def release(self) -> None:
        """Deliver again what was held, and all that follows."""
        self._loop.call_soon_threadsafe(self._flows.set)

    def cut(self, port: int | None = None) -> None:
        """Reset connections, all or those of a port; refuse others until ``mend``."""
        self._run(self._cut(port))

    def half_close(self, end: End) -> None:
        """Tell one end of all connections that the other one sends nothing more.

        What it sends itself still arrives.
        """
        self._run(self._half_close(end))

    def mend(self) -> None:
        """Accept connections again."""
        self._refused.clear()
        self.release()

    def close(self) -> None:
        self._run(self._cut(None))
        self._run(self._end())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    def _run(self, action: Coroutine[Any, Any, None]) -> None:
        asyncio.run_coroutine_threadsafe(action, self._loop).result(10.0)

    async def _listen(self) -> None:
        for (host, port), target in self._routes.items():

            async def serve(
                reader: asyncio.StreamReader,
                writer: asyncio.StreamWriter,
                target: Address = target,
                port: int = port,
            ) -> None:
                await self._serve(reader, writer, target, port)

            self._servers.append(await asyncio.start_server(serve, host, port))

    async def _serve(
        self,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
        target: Address,
        port: int,
    ) -> None:
        if port in self._refused:
            _reset(writer)
            return
        try:
            far_reader, far_writer = await asyncio.open_connection(*target)
        except OSError:
            writer.transport.abort()
            return
        ends = {writer: (End.CLIENT, port), far_writer: (End.SERVER, port)}
        for one in ends:
            one.get_extra_info("socket").setsockopt(
                socket.IPPROTO_TCP, socket.TCP_NODELAY, 1
            )
        self._writers |= ends
        try:
            with contextlib.suppress(asyncio.CancelledError):  # at the end
                await asyncio.gather(
                    self._pump(reader, far_writer), self._pump(far_reader, writer)
                )
        finally:
            for one in ends:
                self._writers.pop(one, None)
                one.close()

    async def _pump(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        """Deliver chunks in order, each when it is due."""
        queue: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue()
        deliver = self._loop.create_task(self._deliver(queue, writer))
        due = 0.0
        with contextlib.suppress(OSError):
            while data := await reader.read(_CHUNK):
                late = self.delay
                if self.jitter:
                    late += self._random.uniform(0.0, self.jitter)
                if self.loss and self._random.random() < self.loss:
                    late += RECOVERY
                due = max(due, self._loop.time() + late) + len(data) / self.rate
                queue.put_nowait((due, data))
        queue.put_nowait((due, b""))
        await deliver

    async def _deliver(
        self, queue: asyncio.Queue[tuple[float, bytes]], writer: asyncio.StreamWriter
    ) -> None:
        with contextlib.suppress(OSError):
            while True:
                due, data = await queue.get()
                if (wait := due - self._loop.time()) > 0.0:
                    await asyncio.sleep(wait)
                await self._flows.wait()
                if not data:
                    break
                if writer not in self._half_closed:
                    writer.write(data)
                    await writer.drain()
            self._write_eof(writer)

    async def _half_close(self, end: End) -> None:
        for writer, (its, _) in tuple(self._writers.items()):
            if its is end:
                self._write_eof(writer)

    def _write_eof(self, writer: asyncio.StreamWriter) -> None:
        if writer not in self._half_closed and not writer.is_closing():
            self._half_closed.add(writer)
            writer.write_eof()

    async def _end(self) -> None:
        for server in self._servers:
            server.close()
        tasks = asyncio.all_tasks() - {asyncio.current_task()}
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _cut(self, port: int | None) -> None:
        ports = {own for _, own in self._routes} if port is None else {port}
        self._refused |= ports
        for writer, (_, own) in tuple(self._writers.items()):
            if own in ports:
                _reset(writer)
        if port is None:
            self._flows.set()


def _reset(writer: asyncio.StreamWriter) -> None:
    """End a connection with RST: what was sent may be lost."""
    linger = struct.pack("ii", 1, 0)  # on, for 0 s
    connection = writer.get_extra_info("socket")
    with contextlib.suppress(OSError):  # it is closed already
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
    writer.transport.abort()


@contextmanager
def link_proxy(routes: Mapping[Address, Address], seed: int = 0) -> Iterator[LinkProxy]:
    """Forward ports until the end of the block."""
    proxy = LinkProxy(routes, seed)
    try:
        yield proxy
    finally:
        proxy.close()
