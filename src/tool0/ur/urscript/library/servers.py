"""Servers of functions: XML-RPC."""

from __future__ import annotations

from typing import Final

from tool0.ur.urscript.execution import Thread
from tool0.ur.urscript.functions import Function, function
from tool0.ur.urscript.kinds import Text
from tool0.ur.urscript.remote import RemoteServer, address_of
from tool0.ur.urscript.values import Value
from tool0.ur.urscript_errors import ValueProblem


async def rpc_factory(thread: Thread, type_: Text, url: Text) -> Value:
    """Return the handle of a server, whose functions are called as its methods."""
    if type_ != "xmlrpc":
        raise ValueProblem(f"the type is '{type_}'; there is 'xmlrpc'")
    host, port = address_of(url)
    sockets = thread.execution.sockets
    sockets.require_allowed(host)
    if not await sockets.answers(host, port):
        raise ValueProblem(f"no server answers at {url}")
    server = RemoteServer(url)
    thread.execution.servers.append(server)
    return server


FUNCTIONS: Final[tuple[Function, ...]] = (function(rpc_factory),)
