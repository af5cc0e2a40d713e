"""What the server has at which path."""

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
from tool0.interfaces.panel.robot_files import URDF_PATH

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable
    from pathlib import Path

    from starlette.requests import Request
    from starlette.types import ASGIApp, Message, Receive, Scope, Send
    from starlette.websockets import WebSocket

    from tool0.interfaces.panel.source import ViewSource

NO_PAGE: Final = (
    "The panel's page is not built: `make run` builds it, or `npm run build` in web/.\n"
    "The robot is there all the same: programs reach it at /ws.\n"
)
_ASK_AGAIN: Final = {"cache-control": "no-cache"}
_FOR_EVER: Final = "public, max-age=31536000, immutable"
_MIME: Final = {
    ".stl": "model/stl",
    ".dae": "model/vnd.collada+xml",
    ".obj": "model/obj",
}


def build_app(
    source: ViewSource,
    serve_page: Callable[[WebSocket], Awaitable[None]],
    endpoint: Endpoint,
    static: Path,
) -> ASGIApp:
    """Return the whole server: guarded, and compressed where that helps.

    Args:
        source: The robot.
        serve_page: Serves the WebSocket of a page.
        endpoint: Where they come in.
        static: The folder of the page, as it was built from ``web/``.
    """
    files = source.facts.files

    async def urdf(request: Request) -> Response:
        etag = f'"{hashlib.sha256(files.urdf).hexdigest()[:16]}"'
        headers = {**_ASK_AGAIN, "etag": etag}
        if request.headers.get("if-none-match") == etag:
            return Response(status_code=304, headers=headers)
        return Response(files.urdf, media_type="application/xml", headers=headers)

    async def mesh(request: Request) -> Response:
        file = files.meshes.get(request.url.path)
        if file is None or not file.is_file():
            return PlainTextResponse("there is no such mesh\n", 404)
        kind = _MIME.get(file.suffix.lower(), "application/octet-stream")
        response = FileResponse(file, media_type=kind, headers=_ASK_AGAIN)
        response.set_stat_headers(file.stat())
        etag = response.headers["etag"]
        if request.headers.get("if-none-match") == etag:
            return Response(status_code=304, headers={**_ASK_AGAIN, "etag": etag})
        return response

    async def page(request: Request) -> Response:
        index = static / "index.html"
        if not index.is_file():
            return PlainTextResponse(NO_PAGE, headers=_ASK_AGAIN)
        return FileResponse(index, headers=_ASK_AGAIN)

    assets = static / "assets"
    app = Starlette(
        routes=[
            Route("/", page),
            Route(URDF_PATH, urdf),
            Route("/meshes/{name}", mesh),
            WebSocketRoute("/ws", serve_page),
            Mount("/assets", _kept(StaticFiles(directory=assets, check_dir=False))),
        ]
    )
    return Guard(GZipMiddleware(app, minimum_size=1024, compresslevel=6), endpoint)


def _kept(app: ASGIApp) -> ASGIApp:
    """Let browsers keep what ``app`` serves: its names change with its contents."""

    async def serve(scope: Scope, receive: Receive, send: Send) -> None:
        async def send_kept(message: Message) -> None:
            if message["type"] == "http.response.start" and message["status"] == 200:
                MutableHeaders(scope=message)["cache-control"] = _FOR_EVER
            await send(message)

        await app(scope, receive, send_kept)

    return serve
