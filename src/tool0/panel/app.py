"""The HTTP routes (page, URDF, meshes, WebSocket) and access control."""

from __future__ import annotations

import hashlib
import secrets
from typing import TYPE_CHECKING, Any, Final, final, get_args
from urllib.parse import parse_qs

from starlette.applications import Starlette
from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware.gzip import GZipMiddleware
from starlette.responses import FileResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles

from tool0.errors import ModelError, RecordingError, RenderError
from tool0.panel.address import Endpoint
from tool0.panel.camera_images import MAX_WIDTH, MIN_WIDTH, ImageKind
from tool0.panel.connection_limits import Visitor
from tool0.panel.robot_info import URDF_PATH

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable
    from pathlib import Path

    from starlette.requests import Request
    from starlette.types import ASGIApp, Message, Receive, Scope, Send
    from starlette.websockets import WebSocket

    from tool0.panel.camera_images import CameraImages
    from tool0.panel.last_recording import LastRecording
    from tool0.panel.robot_info import RobotFiles

POLICY: Final = "; ".join(
    [
        "default-src 'self'",
        "connect-src 'self'",
        "img-src 'self' data: blob:",
        "style-src 'self'",
        "script-src 'self'",
        "worker-src 'self' blob:",
        "frame-ancestors 'none'",
        "base-uri 'none'",
        "form-action 'none'",
    ]
)
_HEADERS: Final = {
    "content-security-policy": POLICY,
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
}
_HTTP_COST: Final = 1e-3
"""Processor time that is charged for the answer to a request [s]."""
_SECRET_PATHS: Final = ("/ws", "/robot.urdf", "/meshes/", "/cameras/", "/recording")
_READING: Final = frozenset({"GET", "HEAD"})


@final
class Guard:
    """ASGI filter that rejects requests to ``app`` from pages of other origins.

    In a browser, any page can open a WebSocket to any address, including addresses of
    this machine.  Browsers always send the origin of the page (``Origin``) and the host
    name that the page used for this server (``Host``).
    """

    def __init__(self, app: ASGIApp, endpoint: Endpoint) -> None:
        self._app = app
        self._endpoint = endpoint

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        refusal = self._refusal(scope)
        if refusal is None:
            visitor = Visitor.of(scope)
            visitor.is_stranger &= not _is_secret(scope)
            with visitor.answered():
                if scope["type"] == "http":
                    await visitor.account.admit()
                    visitor.account.charge(_HTTP_COST)
                await self._app(scope, receive, _with_headers(scope, send))
            return
        status, text = refusal
        response = PlainTextResponse(text + "\n", status, dict(_HEADERS))
        if scope["type"] == "websocket":
            await receive()  # the connect event
        await response(scope, receive, send)

    def _refusal(self, scope: Scope) -> tuple[int, str] | None:
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if not self._endpoint.is_known_as(host):
            address = self._endpoint.url.partition("?")[0]
            return 421, f"this server is not called '{host}'; use {address}"
        origin = headers.get("origin")
        is_socket = scope["type"] == "websocket"
        changes = is_socket or scope["method"] not in _READING
        if (
            changes
            and origin is not None
            and origin.lower() != f"http://{host}".lower()
        ):
            return 403, f"pages from '{origin}' may not drive this robot"
        if self._endpoint.token is not None and _is_secret(scope):
            given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])
            if not secrets.compare_digest(
                given[-1].encode(), self._endpoint.token.encode()
            ):
                return 401, "give the token of the address that bringup printed"
        return None


def _is_secret(scope: Scope) -> bool:
    path: str = scope["path"]
    return path.startswith(_SECRET_PATHS)


def _with_headers(scope: Scope, send: Send) -> Send:
    if scope["type"] != "http":
        return send

    async def send_with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in _HEADERS.items():
                headers.setdefault(name, value)
        await send(message)

    return send_with_headers


NO_PAGE: Final = (
    "The panel's page is not built: `make run` builds it, or `npm run build` in web/.\n"
    "The robot still runs: programs can connect to /ws.\n"
)
_NO_RECORDING: Final = "nothing was recorded, or the file is gone\n"
_REVALIDATE: Final = {"cache-control": "no-cache"}
_UNKEPT: Final = {"cache-control": "no-store"}
_IMMUTABLE: Final = "public, max-age=31536000, immutable"
_MIME: Final = {
    ".stl": "model/stl",
    ".dae": "model/vnd.collada+xml",
    ".obj": "model/obj",
}


@final
class _ImmutableFiles(StaticFiles):
    """Files that browsers may cache, because their names change with their contents."""

    def file_response(self, *args: Any, **options: Any) -> Response:
        response = super().file_response(*args, **options)
        if response.status_code == 200:
            response.headers["cache-control"] = _IMMUTABLE
        return response


def build_app(
    files: RobotFiles,
    serve_page: Callable[[WebSocket], Awaitable[None]],
    endpoint: Endpoint,
    static: Path,
    *,
    recording: LastRecording,
    images: CameraImages | None = None,
) -> ASGIApp:
    """Return the guarded application; ``static`` is the folder of the built page."""

    async def download(request: Request) -> Response:
        file = await recording.file()
        if file is None:
            return PlainTextResponse(_NO_RECORDING, 404)
        # Recordings are already compressed.
        headers = {**_UNKEPT, "content-encoding": "identity"}
        return FileResponse(file, filename=file.name, headers=headers)

    async def replay(request: Request) -> Response:
        file = await recording.file()
        if file is None:
            return PlainTextResponse(_NO_RECORDING, 404)
        try:
            return PlainTextResponse(await recording.replay(file))
        except RecordingError as error:
            return PlainTextResponse(f"{error}\n", 503)

    async def camera(request: Request) -> Response:
        if images is None:
            return PlainTextResponse("this robot has no cameras\n", 404)
        return await _camera_response(images, request)

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

    async def licenses(request: Request) -> Response:
        file = static / "licenses.md"
        if not file.is_file():
            return PlainTextResponse(NO_PAGE, 404)
        return FileResponse(file, media_type="text/plain", headers=_REVALIDATE)

    assets = static / "assets"
    app = Starlette(
        routes=[
            Route("/", page),
            Route("/licenses.md", licenses),
            Route(URDF_PATH, urdf),
            Route("/meshes/{name}", mesh),
            Route("/cameras/{name}/{kind}", camera),
            Route("/recording", download),
            Route("/recording/replay", replay, methods=["POST"]),
            WebSocketRoute("/ws", serve_page),
            Mount("/assets", _ImmutableFiles(directory=assets, check_dir=False)),
        ]
    )
    return Guard(GZipMiddleware(app, minimum_size=1024, compresslevel=6), endpoint)


async def _camera_response(images: CameraImages, request: Request) -> Response:
    """Return an image as PNG, or status 204 if the page already has it."""
    name, kind = request.path_params["name"], request.path_params["kind"]
    if kind not in get_args(ImageKind):
        kinds = " or ".join(get_args(ImageKind))
        return PlainTextResponse(f"no image '{kind}'; ask for {kinds}\n", 404)
    try:
        width = int(request.query_params.get("width", "640"))
        after = int(request.query_params.get("after", "0"))
    except ValueError:
        return PlainTextResponse("width and after must be whole numbers\n", 400)
    if not MIN_WIDTH <= width <= MAX_WIDTH:
        text = f"width must be {MIN_WIDTH} … {MAX_WIDTH} pixels, got {width}\n"
        return PlainTextResponse(text, 400)
    try:
        image = await images.image(name, kind, width, after)
    except (RenderError, ModelError) as error:
        is_unknown = name not in images
        return PlainTextResponse(f"{error}\n", 404 if is_unknown else 503)
    if image is None:
        return Response(status_code=204, headers=_UNKEPT)
    headers = {
        **_UNKEPT,
        "x-image-number": str(image.number),
        "x-image-time": str(image.time),
    }
    return Response(image.png, media_type="image/png", headers=headers)
