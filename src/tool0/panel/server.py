"""The panel, which is a web page with the robot, served over HTTP and WebSocket."""

from __future__ import annotations

import asyncio
import logging
import threading
from collections.abc import Awaitable, Callable, Collection, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final

from starlette.responses import PlainTextResponse
from starlette.websockets import WebSocket, WebSocketDisconnect

from tool0.description.packages import resolve_uri
from tool0.panel.address import Endpoint, open_endpoint
from tool0.protocol.backend import Backend
from tool0.protocol.channel import Connected, backend_of
from tool0.protocol.motion import PoseJoints
from tool0.protocol.request import Request
from tool0.recording.options import episodes_folder, recordings_folder
from tool0.server.peer_files import PeerFiles
from tool0.server.server import Server

if TYPE_CHECKING:
    import uvicorn
    from starlette.types import ASGIApp

    from tool0.panel.camera_images import CameraImages
    from tool0.panel.connection_limits import Entrance
    from tool0.panel.last_recording import LastRecording
    from tool0.panel.replay.view import Replay
    from tool0.panel.view import RobotView
    from tool0.panel.view_feed import ViewFeed, ViewSource
    from tool0.server.budget import Account
    from tool0.server.hub import Hub

logger = logging.getLogger(__name__)

STATIC: Final = Path(__file__).parent / "static"
"""Folder of the page, which is built from ``web/``."""

MAX_PAGES: Final = 64
GOING_AWAY: Final = 1001
FULL: Final = 503
_MAX_MESSAGE: Final = 1 << 16
"""Largest size of a message from a page [bytes].  A larger message ends the
connection."""
_FAULTS_OF_PAGES: Final = (
    "ASGI callable returned without completing handshake.",  # a page that is refused
    "Invalid UTF-8 sequence received from client.",
)
_PING_PERIOD: Final = 20.0
"""Wall time between checks of whether an inactive page is still connected [s]."""


def is_page_built() -> bool:
    """Return whether the page has been built."""
    return (STATIC / "index.html").is_file()


def load() -> None:
    """Import the server's modules before a control loop is started.

    Otherwise, the server's thread imports the modules later, which delays ticks by 0.1
    s.
    """
    import uvicorn.protocols.http.h11_impl
    import uvicorn.protocols.websockets.websockets_sansio_impl  # noqa: F401

    import tool0.panel.app
    import tool0.panel.connection_limits
    import tool0.panel.simulation_view
    import tool0.panel.view_feed  # noqa: F401


@final
class WebService:
    """Service of a hub's robot as a web page; see ``server.hub.Service``.

    The address can be used immediately.  The page is served once the server has been
    loaded.
    """

    starts_at_once: Final = True

    def __init__(
        self,
        source: Callable[[], ViewSource],
        endpoint: Endpoint,
        setpoint_requests: tuple[type[Request[Any]], ...] = (),
        folder: Path | None = None,
    ) -> None:
        """Prepare the service; the endpoint is already listening.

        Args:
            source: Function that creates the source of the view in the server's thread.
            endpoint: The listening socket.
            setpoint_requests: Classes of additional requests that pages send as
                streams.
            folder: Folder in which the requests of pages may read and write files, in
                addition to the user's folders for recordings and episodes.
        """
        own = (recordings_folder(), episodes_folder())
        self._folders = own if folder is None else (*own, folder)
        self._make_source = source
        self._endpoint = endpoint
        self.listener = endpoint.listener
        self.url = endpoint.url
        """The page's address, with the token if one is required."""
        self._setpoint_requests = setpoint_requests
        self._shown = threading.Event()
        self._feed: ViewFeed | None = None
        self._images: CameraImages | None = None
        self._recording: LastRecording | None = None
        self._server: uvicorn.Server | None = None
        self._serving: asyncio.Task[None] | None = None
        self._entrance: Entrance | None = None

    def await_page(self, timeout: float | None = None) -> bool:
        """Wait for up to ``timeout`` [wall s] until a page has drawn the robot.

        Return whether a page has drawn the robot.
        """
        return self._shown.wait(timeout)

    async def start(self, hub: Hub) -> None:
        import uvicorn

        from tool0.panel.app import build_app
        from tool0.panel.camera_images import CameraImages
        from tool0.panel.connection_limits import Entrance
        from tool0.panel.last_recording import LastRecording
        from tool0.panel.view_feed import ViewFeed

        source = self._make_source()
        hub.when_shown = self._shown.set
        hub.setpoint_requests += self._setpoint_requests
        self._feed = ViewFeed(source, hub)
        if source.cameras is not None:
            self._images = CameraImages(source.cameras)
        self._recording = LastRecording(hub.backend, self._endpoint.host)
        app = build_app(
            source.files,
            self._serve_page(hub, source),
            self._endpoint,
            STATIC,
            recording=self._recording,
            images=self._images,
        )
        self._server = server = uvicorn.Server(_configuration(app))
        logging.getLogger("uvicorn.error").addFilter(_is_problem)
        self._serving = asyncio.create_task(server.serve(sockets=[]))

        def make_protocol(state: dict[str, Any]) -> asyncio.Protocol:
            protocol: asyncio.Protocol = server.config.http_protocol_class(  # type: ignore[call-arg]  # uvicorn's own
                config=server.config, server_state=server.server_state, app_state=state
            )
            return protocol

        self._entrance = Entrance(self.listener, make_protocol, hub.budget)

    async def stop(self) -> None:
        if self._entrance is not None:
            self._entrance.close()
        if self._feed is not None:
            self._feed.close()
        if self._images is not None:
            self._images.close()
        if self._recording is not None:
            await self._recording.close()

    async def end(self) -> None:
        if self._server is not None and self._serving is not None:
            self._server.should_exit = True
            await asyncio.wait([self._serving])

    def release(self) -> None:
        self.listener.close()

    def _serve_page(
        self, hub: Hub, source: ViewSource
    ) -> Callable[[WebSocket], Awaitable[None]]:
        n_pages = 0

        def known() -> Collection[Path]:
            source.frame()  # updates the known files
            return source.files.known

        files = PeerFiles(folders=self._folders, known=known, resolve=resolve_uri)

        async def serve(socket: WebSocket) -> None:
            nonlocal n_pages
            if n_pages >= MAX_PAGES:
                text = f"{MAX_PAGES} pages are connected already; close one\n"
                await socket.send_denial_response(PlainTextResponse(text, FULL))
                return
            await socket.accept()
            n_pages += 1
            try:
                await hub.serve(_PageTransport(socket, files))
            finally:
                n_pages -= 1

        return serve


@final
class _PageTransport:
    """Connection to one page; see ``session.Transport``."""

    is_trusted: Final = False

    def __init__(self, socket: WebSocket, files: PeerFiles) -> None:
        from tool0.panel.connection_limits import Visitor

        self.files = files
        self._socket = socket
        self._visitor = Visitor.of(socket.scope)

    @property
    def account(self) -> Account:
        return self._visitor.account

    async def send(self, texts: Sequence[bytes]) -> None:
        try:
            for text in texts:
                await self._socket.send_text(text.decode())
                await self.account.give_way()
        except (WebSocketDisconnect, RuntimeError):
            # uvicorn raises RuntimeError after it has closed the connection for an
            # invalid frame.
            raise ConnectionError from None

    async def receive(self) -> bytes | str | None:
        event = await self._socket.receive()
        if event["type"] == "websocket.disconnect":
            return None
        text: str | None = event.get("text")
        data: bytes | None = event.get("bytes")
        return data if text is None else text

    async def close(self) -> None:
        await self._socket.close(GOING_AWAY, "the server ends")

    def abort(self) -> None:
        self._visitor.drop()  # a close would wait for the page


@final
class Panel(AbstractContextManager["Panel"]):
    """Server of a robot as a web page, from its construction to ``close``."""

    def __init__(
        self,
        robot: Connected | RobotView | Replay,
        host: str | None = None,
        port: int | None = None,
        token: str | None = None,
        *,
        endpoint: Endpoint | None = None,
    ) -> None:
        """Start serving the page.

        Args:
            robot: A robot in this process, a robot without physics, or a recording.
            host: Name or address of this machine (default: the loopback address).
            port: Port number (default: the default port, or a free port if the default
                port is in use).
            token: Token that pages must send; see ``open_endpoint``.
            endpoint: A listening socket that replaces ``host``, ``port`` and ``token``.

        Raises:
            TransportError: If the address is in use or is not an address of this
                machine.
        """
        endpoint = endpoint or open_endpoint(host, port, token)
        backend, service = panel_service(robot, endpoint)
        self.url = service.url
        """The page's address, with the token if one is required."""
        self.await_page = service.await_page
        self._server = Server(backend, [service])

    def close(self) -> None:
        """Close all connections and stop serving; further calls have no effect."""
        self._server.close()

    def __exit__(self, *_: object) -> None:
        self.close()


def panel_service(
    robot: Connected | RobotView | Replay,
    endpoint: Endpoint,
    folder: Path | None = None,
) -> tuple[Backend, WebService]:
    """Return the backend and the service with which a server shows ``robot``.

    See ``WebService`` for ``folder``.
    """
    if isinstance(robot, Connected):
        backend = backend_of(robot.channel)

        def view() -> ViewSource:
            from tool0.panel.simulation_view import SimulationView

            return SimulationView(backend)

        return backend, WebService(view, endpoint, folder=folder)
    return robot, WebService(lambda: robot, endpoint, (PoseJoints,))


def _configuration(app: ASGIApp) -> uvicorn.Config:
    import uvicorn

    config = uvicorn.Config(
        app,
        loop="asyncio",
        http="h11",
        ws="websockets-sansio",
        lifespan="off",
        log_config=None,
        log_level=logging.WARNING,
        access_log=False,
        proxy_headers=False,
        server_header=False,
        ws_max_size=_MAX_MESSAGE,
        ws_ping_interval=_PING_PERIOD,
        ws_ping_timeout=_PING_PERIOD,
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=1,
    )
    config.load()
    return config


def _is_problem(record: logging.LogRecord) -> bool:
    """Return False for a log record about a fault of a page, and True otherwise."""
    return record.getMessage() not in _FAULTS_OF_PAGES
