"""The HTTP routes: page, URDF, meshes and WebSocket."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Final

from starlette.applications import Starlette
from starlette.datastructures import MutableHeaders
from starlette.middleware.gzip import GZipMiddleware
from starlette.responses import FileResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles

from tool0.interfaces.panel.address import Endpoint
from tool0.interfaces.panel.guard import Guard
from tool0.interfaces.panel.robot_info import URDF_PATH

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable
    from pathlib import Path

    from starlette.requests import Request
    from starlette.types import ASGIApp, Message, Receive, Scope, Send
    from starlette.websockets import WebSocket

    from tool0.interfaces.panel.robot_info import RobotFiles

NO_PAGE: Final = (
    "The panel's page is not built: `make run` builds it, or `npm run build` in web/.\n"
    "The robot runs all the same: programs can connect to /ws.\n"
)
_REVALIDATE: Final = {"cache-control": "no-cache"}
_IMMUTABLE: Final = "public, max-age=31536000, immutable"
_MIME: Final = {
    ".stl": "model/stl",
    ".dae": "model/vnd.collada+xml",
    ".obj": "model/obj",
}


def build_app(
    files: RobotFiles,
    serve_page: Callable[[WebSocket], Awaitable[None]],
    endpoint: Endpoint,
    static: Path,
) -> ASGIApp:
    """Return the guarded application, with compression where that helps.

    Args:
        files: The URDF and the meshes.
        serve_page: Serves the WebSocket of a page.
        endpoint: The listening socket.
        static: The folder of the page, as it was built from ``web/``.
    """

    async def urdf(request: Request) -> Response:
        etag = f'"{hashlib.sha256(files.urdf).hexdigest()[:16]}"'
        headers = {**_REVALIDATE, "etag": etag}
        if request.headers.get("if-none-match") == etag:
            return Response(status_code=304, headers=headers)
        return Response(files.urdf, media_type="application/xml", headers=headers)

    async def mesh(request: Request) -> Response:
        file = files.meshes.get(request.url.path)
        if file is None or not file.is_file():
            return PlainTextResponse("there is no such mesh\n", 404)
        kind = _MIME.get(file.suffix.lower(), "application/octet-stream")
        response = FileResponse(file, media_type=kind, headers=_REVALIDATE)
        response.set_stat_headers(file.stat())
        etag = response.headers["etag"]
        if request.headers.get("if-none-match") == etag:
            return Response(status_code=304, headers={**_REVALIDATE, "etag": etag})
        return response

    async def page(request: Request) -> Response:
        index = static / "index.html"
        if not index.is_file():
            return PlainTextResponse(NO_PAGE, headers=_REVALIDATE)
        return FileResponse(index, headers=_REVALIDATE)

    assets = static / "assets"
    app = Starlette(
        routes=[
            Route("/", page),
            Route(URDF_PATH, urdf),
            Route("/meshes/{name}", mesh),
            WebSocketRoute("/ws", serve_page),
            Mount("/assets", _cached(StaticFiles(directory=assets, check_dir=False))),
        ]
    )
    return Guard(GZipMiddleware(app, minimum_size=1024, compresslevel=6), endpoint)


def _cached(app: ASGIApp) -> ASGIApp:
    """Let browsers keep what ``app`` serves: its names change with its contents."""

    async def serve(scope: Scope, receive: Receive, send: Send) -> None:
        async def send_cached(message: Message) -> None:
            if message["type"] == "http.response.start" and message["status"] == 200:
                MutableHeaders(scope=message)["cache-control"] = _IMMUTABLE
            await send(message)

        await app(scope, receive, send_cached)

    return serve
