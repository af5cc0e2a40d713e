"""Access control: our own pages and programs, but no pages of other origins.

Browsers let any page open a WebSocket to any address, this machine's included.  They
always send the page's origin (``Origin``) and the name it used for us (``Host``).
"""

from __future__ import annotations

import secrets
from typing import TYPE_CHECKING, Final, final
from urllib.parse import parse_qs

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse

from tool0.interfaces.panel.address import Endpoint

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

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
_SECRET_PATHS: Final = ("/ws", "/robot.urdf", "/meshes/")
_READING: Final = frozenset({"GET", "HEAD"})


@final
class Guard:
    """Passes a request to ``app``, or refuses it with a short text."""

    def __init__(self, app: ASGIApp, endpoint: Endpoint) -> None:
        self._app = app
        self._endpoint = endpoint

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        refusal = self._refusal(scope)
        if refusal is None:
            await self._app(scope, receive, _with_headers(scope, send))
            return
        status, text = refusal
        response = PlainTextResponse(text + "\n", status, dict(_HEADERS))
        if scope["type"] == "websocket":
            await receive()  # what opens it; refused before it is accepted
        await response(scope, receive, send)

    def _refusal(self, scope: Scope) -> tuple[int, str] | None:
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if not self._endpoint.is_known_as(host):
            return 421, f"this server is not called '{host}'; use {self._address}"
        origin = headers.get("origin")
        is_socket = scope["type"] == "websocket"
        changes = is_socket or scope["method"] not in _READING
        if (
            changes
            and origin is not None
            and origin.lower() != f"http://{host}".lower()
        ):
            return 403, f"pages from '{origin}' may not drive this robot"
        if self._endpoint.token is not None and scope["path"].startswith(_SECRET_PATHS):
            given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])
            if not secrets.compare_digest(
                given[-1].encode(), self._endpoint.token.encode()
            ):
                return 401, "give the token of the address that bringup printed"
        return None

    @property
    def _address(self) -> str:
        return self._endpoint.url.partition("?")[0]


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
