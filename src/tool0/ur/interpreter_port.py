"""The port of the interpreter mode; each line contains a command or statements."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, final

from tool0.ur.listening import REQUEST_COST, Peer, Port
from tool0.ur.urscript.interpreter import NOT_RUNNING, STATES, discarded

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox

PORT: Final = 30020
_COST: Final = 1e-3
"""Processor time for compiling a line [s]."""


@final
class InterpreterPort:
    """Passes lines to the interpreter of the running program."""

    def __init__(self, box: UrControlBox) -> None:
        self._box = box
        self._port = Port("interpreter mode", self._serve)

    async def start(self, host: str, port_base: int) -> None:
        """Open the port; raise TransportError if the port is in use."""
        await self._port.listen(host, PORT + port_base)

    async def close(self) -> None:
        """Close the port and its connections."""
        await self._port.close()

    async def _serve(self, peer: Peer) -> None:
        def reply(line: str) -> None:
            peer.send(f"{line}\n".encode())

        while data := await peer.reader.readline():
            text = data.decode(errors="replace").strip()
            if not text:
                continue
            interpreter = self._box.interpreter
            if interpreter is None and text in STATES:
                reply(f"state: 0: {text}")
            elif interpreter is None:
                reply(discarded(NOT_RUNNING, text))
            else:
                interpreter.submit(text, reply)
            await peer.account.pay(REQUEST_COST + _COST)
