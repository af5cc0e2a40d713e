"""XML-RPC servers with functions that a program can call over HTTP.

A call waits in a separate thread, because the server, such as a camera, may need any
amount of time. If the program is stopped during the call, the connection is closed,
which ends the call.
"""

from __future__ import annotations

import asyncio
import http.client
import socket
import threading
import xmlrpc.client
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, Final, cast, final
from urllib.parse import urlsplit
from xml.parsers.expat import ExpatError

from tool0.ur.urscript_errors import ValueProblem

OPEN_TIMEOUT: Final = 2.0
"""Maximum time to wait for a connection [wall s]."""
MAX_RESPONSE: Final = 1 << 20
"""Maximum size of a server's response [bytes]."""
CLOSE: Final = "closeXMLRPCClientConnection"
"""Name of the only method that is not a function of the server."""
_CHUNK: Final = 1 << 16


@final
class _Connection(http.client.HTTPConnection):
    """A connection with a timeout for connecting and no timeout for replies."""

    is_abandoned = False

    def connect(self) -> None:
        super().connect()
        self.sock.settimeout(None)
        if self.is_abandoned:
            self.close()
            raise ConnectionAbortedError("the connection was closed")

    def abandon(self) -> None:
        """Close the connection; a thread that waits for a reply receives an error."""
        self.is_abandoned = True
        if self.sock is not None:
            with suppress(OSError):
                self.sock.shutdown(socket.SHUT_RDWR)
            self.sock.close()


@final
class _Transport(xmlrpc.client.Transport):
    """A transport that limits the size of responses and accepts no compression."""

    accept_gzip_encoding = False

    def __init__(self) -> None:
        super().__init__()
        self._live: _Connection | None = None

    # Any: the signatures are those of the standard library.
    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        if self._live is None:
            self._live = _Connection(host, timeout=OPEN_TIMEOUT)
        return self._live

    def close(self) -> None:
        """Discard the connection after it has ended."""
        live, self._live = self._live, None
        if live is not None:
            live.close()

    def abandon(self) -> None:
        """End the connection."""
        live, self._live = self._live, None
        if live is not None:
            live.abandon()

    def request(
        self, host: Any, handler: str, request_body: Any, verbose: bool = False
    ) -> Any:
        """Send a request; repeat it if the server has closed an earlier connection."""
        live = self._live
        try:
            return self.single_request(host, handler, request_body, verbose)
        except ConnectionError:
            if live is None or live.is_abandoned:
                raise
        return self.single_request(host, handler, request_body, verbose)

    def parse_response(self, response: Any) -> Any:
        parser, unmarshaller = self.getparser()
        size = 0
        while data := response.read(_CHUNK):
            size += len(data)
            if size > MAX_RESPONSE:
                raise ValueProblem(f"the response has more than {MAX_RESPONSE} bytes")
            parser.feed(data)
        parser.close()
        return unmarshaller.close()


@final
class RemoteServer:
    """A handle that ``rpc_factory`` returns; its methods are functions of a server."""

    def __init__(self, url: str, when_closed: Callable[[RemoteServer], object]) -> None:
        """Create a handle without connecting to the server.

        Args:
            url: URL of the server, which has been checked.
            when_closed: Function that is called when the connection has been closed.
        """
        self._when_closed = when_closed
        host, port = address_of(url)  # only the parts of the URL that were checked
        self._host = f"{host}:{port}"
        self._path = urlsplit(url).path or "/RPC2"
        self._transport = _Transport()
        self._turn = asyncio.Lock()

    async def call(self, name: str, arguments: Sequence[object]) -> object:
        """Return the result of a server's function as a value of xmlrpc.client.

        Raises:
            ValueProblem: If the function cannot be called or fails; the error contains
                the reason.
        """
        given = cast("Any", tuple(arguments))
        body = xmlrpc.client.dumps(given, name).encode()
        async with self._turn:
            answer = await self._apart(
                lambda: self._transport.request(self._host, self._path, body)
            )
        return cast("tuple[object]", answer)[0]

    def close(self) -> None:
        """Close the connection; the next call opens a new connection."""
        self._transport.abandon()
        self._when_closed(self)

    async def _apart(self, action: Callable[[], object]) -> object:
        """Run an action in a separate thread and return its result."""
        loop = asyncio.get_running_loop()
        done: asyncio.Future[Callable[[], object]] = loop.create_future()

        def finish(outcome: Callable[[], object]) -> None:
            if not done.done():
                done.set_result(outcome)

        def run() -> None:
            outcome = _outcome(action)
            with suppress(RuntimeError):  # the loop has ended
                loop.call_soon_threadsafe(finish, outcome)

        threading.Thread(target=run, daemon=True, name="urscript-rpc").start()
        try:
            outcome = await done
        except asyncio.CancelledError:
            self.close()
            raise
        return outcome()


def _outcome(action: Callable[[], object]) -> Callable[[], object]:
    """Return a function that returns the action's result or raises its error."""
    try:
        result = action()
    except ValueProblem as problem:
        text = str(problem)
    except xmlrpc.client.Fault as fault:
        text = f"the server answers with an error: {fault.faultString}"
    except xmlrpc.client.ProtocolError as error:
        text = f"the server answers HTTP {error.errcode} {error.errmsg}"
    except (xmlrpc.client.ResponseError, ExpatError):
        text = "the server's answer is not XML-RPC"
    except (OSError, http.client.HTTPException) as error:
        text = f"there is no answer: {error}"
    except (ValueError, TypeError) as error:
        text = f"the server's answer cannot be read: {error}"
    else:
        return lambda: result

    def fail() -> object:
        raise ValueProblem(text)

    return fail


def address_of(url: str) -> tuple[str, int]:
    """Return the host and port in the URL of an XML-RPC server.

    Raises:
        ValueProblem: If the URL does not have the form ``http://ADDRESS:PORT/PATH``.
    """
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError:
        host, port = None, None
    if host is None or parts.scheme != "http":
        raise ValueProblem(f"'{url}' is not like http://127.0.0.1:8080/RPC2")
    return "127.0.0.1" if host == "localhost" else host, port or http.client.HTTP_PORT
