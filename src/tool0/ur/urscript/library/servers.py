"""Functions that give programs access to XML-RPC servers."""

from __future__ import annotations

from typing import Final

from tool0.ur.urscript.execution import Thread
from tool0.ur.urscript.functions import Function, function
from tool0.ur.urscript.kinds import Text
from tool0.ur.urscript.remote import CLOSE, RemoteServer, address_of
from tool0.ur.urscript.values import Value
from tool0.ur.urscript_errors import ValueProblem

MAX_SERVERS: Final = 64
"""Maximum number of open handles of a program."""


async def rpc_factory(thread: Thread, type_: Text, url: Text) -> Value:
    """Return a handle of a server, with methods that call the server's functions."""
    if type_ != "xmlrpc":
        raise ValueProblem(f"the type is '{type_}'; there is 'xmlrpc'")
    if len(thread.execution.servers) >= MAX_SERVERS:
        raise ValueProblem(f"{MAX_SERVERS} handles are open; close some with {CLOSE}()")
    host, port = address_of(url)
    sockets = thread.execution.sockets
    sockets.require_allowed(host)
    if not await sockets.answers(host, port):
        raise ValueProblem(f"no server answers at {url}")
    servers = thread.execution.servers
    server = RemoteServer(url, when_closed=servers.discard)
    servers.add(server)
    return server


FUNCTIONS: Final[tuple[Function, ...]] = (function(rpc_factory),)
