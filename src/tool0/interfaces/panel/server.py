"""The panel's server: a thread of its own with an event loop of its own."""

from __future__ import annotations

import asyncio
import logging
import threading
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Final, final

from tool0.interfaces.panel.address import Door, open_door
from tool0.runtime.robot import Robot

if TYPE_CHECKING:
    import uvicorn
    from starlette.websockets import WebSocket

    from tool0.interfaces.panel.source import PanelSource

logger = logging.getLogger(__name__)

STATIC: Final = Path(__file__).parent / "static"
"""The page, made from ``web/``."""

_LARGEST: Final = 1 << 20
"""Bytes of a message from which the connection ends; smaller ones are answered."""
_PING: Final = 20.0
"""Wall time between two looks at whether a silent page is still there [s]."""
_CLOSES_WITHIN: Final = 5.0
"""[wall s]"""


def is_page_built() -> bool:
    """Return whether there is a page to serve."""
    return (STATIC / "index.html").is_file()


def load() -> None:
    """Import what the server needs: 0.1 s in which a control loop would be late.

    The server's thread does it otherwise, so that a panel can be had at once.
    """
    import uvicorn.protocols.http.h11_impl
    import uvicorn.protocols.websockets.websockets_sansio_impl  # noqa: F401

    import tool0.interfaces.panel.app
    import tool0.interfaces.panel.hub
    import tool0.interfaces.panel.simulation  # noqa: F401


@final
class Panel:
    """Serves a robot as a web page, from construction to ``close``.

    The address can be used at once; the page comes as soon as the server is loaded.
    """

    def __init__(
        self,
        source: Robot | PanelSource,
        host: str | None = None,
        port: int | None = None,
        token: str | None = None,
        *,
        door: Door | None = None,
    ) -> None:
        """Begin to serve.

        Args:
            source: A robot, or what else pages may see.
            host: The name or address to listen at; only this machine's own programs
                can come in if left out.
            port: 8085 if left out, or a free one if that is taken.
            token: What pages must show; a new one, if host or port is given without.
            door: A listening socket, instead of host, port and token.

        Raises:
            TransportError: If the address is taken or is not this machine's.
        """
        self._source = source
        self._door = door or open_door(host, port, token)
        self._loop = asyncio.new_event_loop()
        self._stop = asyncio.Event()
        self._shown = threading.Event()
        self._thread = threading.Thread(
            target=self._run, name="tool0-panel", daemon=True
        )
        self._thread.start()

    @property
    def url(self) -> str:
        """The page's address, with the token if it needs one."""
        return self._door.url

    def await_page(self, timeout: float | None = None) -> bool:
        """Wait until a page has connected, at any time; return whether one has.

        Args:
            timeout: Longest wait [wall s]; None waits for ever.
        """
        return self._shown.wait(timeout)

    def close(self) -> None:
        """Say goodbye to every page and end; closing twice is allowed."""
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._stop.set)
            self._thread.join(_CLOSES_WITHIN)

    def __enter__(self) -> Panel:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def _run(self) -> None:
        try:
            self._loop.run_until_complete(self._serve())
        except Exception:  # the robot runs on without its page
            logger.exception("the panel's server failed")
        finally:
            self._door.listener.close()
            self._loop.run_until_complete(_end_tasks())
            self._loop.close()

    async def _serve(self) -> None:
        import uvicorn

        from tool0.interfaces.panel.app import build_app
        from tool0.interfaces.panel.hub import Hub

        source = _as_source(self._source)
        connections: list[uvicorn.Server] = []
        hub = Hub(source, lambda socket: _cut(connections, socket), self._shown.set)
        server = uvicorn.Server(
            uvicorn.Config(
                build_app(source, hub, self._door, STATIC),
                loop="asyncio",
                http="h11",
                ws="websockets-sansio",
                lifespan="off",
                log_config=None,
                log_level=logging.WARNING,
                access_log=False,
                proxy_headers=False,
                server_header=False,
                ws_max_size=_LARGEST,
                ws_ping_interval=_PING,
                ws_ping_timeout=_PING,
                ws_per_message_deflate=False,
                timeout_graceful_shutdown=1,
            )
        )
        connections.append(server)
        logging.getLogger("uvicorn.error").addFilter(_is_news)
        serving = asyncio.create_task(server.serve(sockets=[self._door.listener]))
        stopping = asyncio.create_task(self._stop.wait())
        await asyncio.wait((serving, stopping), return_when=asyncio.FIRST_COMPLETED)
        stopping.cancel()
        await hub.close()
        server.should_exit = True
        await serving


async def _end_tasks() -> None:
    """End what is left in the loop, such as a page that never said goodbye."""
    tasks = asyncio.all_tasks() - {asyncio.current_task()}
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


def _is_news(record: logging.LogRecord) -> bool:
    """Return False for what uvicorn says of every refused page: nothing went wrong."""
    return "without completing handshake" not in record.getMessage()


def _as_source(source: Robot | PanelSource) -> PanelSource:
    if not isinstance(source, Robot):
        return source
    from tool0.interfaces.panel.simulation import SimulationSource

    return SimulationSource(source)


def _cut(servers: list[uvicorn.Server], socket: WebSocket) -> None:
    """End a connection at once: closing would wait until the page reads."""
    peer = socket.scope["client"], socket.scope["server"]
    for server in servers:
        connection: Any  # each protocol of uvicorn has these, and no common type
        for connection in list(server.server_state.connections):
            if (connection.client, connection.server) == peer:
                connection.transport.abort()
