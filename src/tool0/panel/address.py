"""The panel's address, with its listening socket, token and host names."""

from __future__ import annotations

import errno
import functools
import ipaddress
import os
import re
import secrets
import socket
from dataclasses import dataclass
from typing import Final, final
from urllib.parse import quote

from tool0.errors import TransportError

DEFAULT_HOST: Final = "127.0.0.1"
DEFAULT_PORT: Final = 8085
TOKEN_VARIABLE: Final = "TOOL0_PANEL_TOKEN"
_LOOPBACK_NAMES: Final = frozenset({"127.0.0.1", "localhost", "::1"})
_PORT: Final = re.compile(r"[0-9]{1,5}")
_SEND_BUFFER: Final = 65536
"""Size of the system's send buffer for a page [bytes]: enough for two seconds of
frames.  With the system's default of several megabytes, a slow page would lag half a
minute behind the robot."""
_RECEIVE_BUFFER: Final = 32768
"""Size of the system's receive buffer for a page [bytes]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Endpoint:
    """A listening socket, where connections wait until the server accepts them."""

    listener: socket.socket
    host: str
    """The requested host name or address, without brackets."""
    port: int
    token: str | None
    """Token that ``/ws``, the URDF and the meshes require; None if the server listens
    only on the loopback interface and no token was given."""

    @property
    def url(self) -> str:
        """The page's address, including the token."""
        host = self.host
        if _is_any(host):
            host = socket.gethostname()
        shown = f"[{host}]" if ":" in host else host
        query = "" if self.token is None else f"?token={quote(self.token, safe='')}"
        return f"http://{shown}:{self.port}/{query}"

    def is_known_as(self, host_header: str) -> bool:
        """Return whether the header ``Host`` contains a valid name of this server.

        The owner of a foreign page can make the page's host name resolve to this
        machine (DNS rebinding), in which case the browser sends the foreign name.  If a
        token is required, the port may differ, because a container or a tunnel may map
        it.
        """
        name, port = _split(host_header)
        is_chosen = name in _LOOPBACK_NAMES or name == self.host.lower()
        if self.token is None:
            return is_chosen and port == self.port
        if is_chosen or not _is_any(self.host):
            return is_chosen
        return _is_ip(name) or name in _own_names()


def open_endpoint(
    host: str | None = None, port: int | None = None, token: str | None = None
) -> Endpoint:
    """Start listening and return the endpoint.

    Args:
        host: Name or address of this machine (default: the loopback address).
        port: Port number (default: the default port, or a free port if the default port
            is in use).
        token: Token that clients must send.  If a host or a port is given without a
            token, the value of the environment variable is used.  If there is no value
            and the host is not the loopback address, a new token is generated.

    Raises:
        TransportError: If the address is in use or is not an address of this machine.
    """
    if port is not None and not 0 <= port <= 65535:
        raise TransportError(f"port {port} is invalid; choose one in 0 … 65535")
    if token is None and (host is not None or port is not None):
        token = os.environ.get(TOKEN_VARIABLE) or None
    where = (host or DEFAULT_HOST).removeprefix("[").removesuffix("]")
    try:
        listener = _listen(where, DEFAULT_PORT if port is None else port)
    except OSError as error:
        if port is not None or error.errno != errno.EADDRINUSE:
            raise _refusal(where, port, error) from None
        listener = _listen(where, 0)
    address, chosen_port = listener.getsockname()[:2]
    if token is None and not ipaddress.ip_address(address).is_loopback:
        token = secrets.token_urlsafe(16)
    return Endpoint(listener=listener, host=where, port=chosen_port, token=token)


def _listen(host: str, port: int) -> socket.socket:
    family, kind, protocol, _, address = socket.getaddrinfo(
        host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
    )[0]
    listener = socket.socket(family, kind, protocol)
    try:
        if os.name == "posix":  # otherwise, this would share the port
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        # Connections inherit the buffer sizes of the listener.
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BUFFER)
        listener.bind(address)
        listener.listen(128)
        listener.setblocking(False)
    except OSError:
        listener.close()
        raise
    return listener


def _refusal(host: str, port: int | None, error: OSError) -> TransportError:
    if error.errno == errno.EADDRINUSE:
        return TransportError(
            f"port {port} of {host} is taken; choose another with --panel-port, or "
            "end what listens there"
        )
    return TransportError(
        f"cannot listen at {host}, port {port or DEFAULT_PORT}: "
        f"{error.strerror or error}; give a name or address of this machine"
    )


def _split(host_header: str) -> tuple[str, int | None]:
    """Return the name in lower case without brackets, and the port.

    If the header contains no port, the port is 80.  If the port is invalid, it is
    returned as None.
    """
    name, colon, port = host_header.strip().lower().rpartition(":")
    if not colon or "]" in port:
        name, port = host_header.strip().lower(), "80"
    if name.startswith("[") and name.endswith("]"):
        name = name[1:-1]
    return name, int(port) if _PORT.fullmatch(port) else None


@functools.cache
def _own_names() -> frozenset[str]:
    """Return the names of this machine; the lookup may be slow."""
    return frozenset({socket.gethostname().lower(), socket.getfqdn().lower()})


def _is_any(host: str) -> bool:
    return _is_ip(host) and ipaddress.ip_address(host).is_unspecified


def _is_ip(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
