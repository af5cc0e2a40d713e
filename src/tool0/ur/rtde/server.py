"""The server on port 30004, where clients exchange fields with the control box."""

from __future__ import annotations

import asyncio
import logging
import math
import struct
from typing import TYPE_CHECKING, Final, final

from tool0.devices.rtde_packets import (
    PORT,
    VERSIONS,
    Level,
    PacketBuffer,
    PacketType,
    field_names,
    packet,
    text_packet,
)
from tool0.errors import TransportError
from tool0.ur.listening import Peer, Port
from tool0.ur.rtde.inputs import IN_USE, InputClaims, InputRecipe
from tool0.ur.rtde.outputs import NOT_FOUND, OutputRecipe, output_types

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox

logger = logging.getLogger(__name__)

MAX_RECIPES: Final = 255
"""Maximum number of input recipes per connection, because a recipe number is one byte
long."""
MAX_UNREAD: Final = 1 << 15
"""Amount of unread data above which no more data is sent to a client [bytes]."""
SLOW_TIMEOUT: Final = 5.0
"""Time after which a client with more unread data than ``MAX_UNREAD`` is disconnected
[wall s]."""
HEARTBEAT: Final = 0.1
"""Period at which data is sent while there are no updates [wall s]. The simulation may
be paused, and clients interpret a lack of data as a lost connection."""
VERSION_1_RATE: Final = 125.0
"""Rate for clients with version 1 of the protocol, which cannot choose the rate
[Hz]."""

_CHUNK: Final = 1 << 16
_VERSION: Final = struct.Struct(">H")
_CONTROL_VERSION: Final = struct.Struct(">4I")
_FREQUENCY: Final = struct.Struct(">d")


@final
class RtdeServer:
    """The RTDE interface of a control box."""

    def __init__(self, box: UrControlBox) -> None:
        self._box = box
        self._claims = InputClaims()
        self._port = Port("RTDE", self._serve)
        self._clients: set[_Client] = set()
        self._published = 0.0
        self._heart: asyncio.Task[None] | None = None

    async def start(self, host: str, port_base: int) -> None:
        """Open the port; raise TransportError if the port is in use."""
        await self._port.listen(host, port_base + PORT)
        self._box.when_shown.add(self._publish)
        self._heart = asyncio.create_task(self._beat())

    async def close(self) -> None:
        """Close the port and its connections."""
        self._box.when_shown.discard(self._publish)
        if self._heart is not None:
            self._heart.cancel()
        await self._port.close()

    async def _serve(self, peer: Peer) -> None:
        client = _Client(self._box, peer, self._claims)
        self._clients.add(client)
        try:
            await client.serve()
        finally:
            self._clients.discard(client)
            self._claims.release(client)

    def _publish(self, *, to_all: bool = False) -> None:
        """Send the state to the clients that are due; pack each recipe only once."""
        self._published = now = asyncio.get_running_loop().time()
        packed: dict[OutputRecipe, bytes] = {}
        for client in self._clients:
            recipe = client.outputs
            if recipe is None or not (client.is_due(self._box.time) or to_all):
                continue
            if client.is_slow(now):
                continue
            if recipe not in packed:
                try:
                    values = recipe.pack(self._box)
                except struct.error as error:  # a register's value is out of range
                    logger.warning("RTDE: %s", error)
                    continue
                packed[recipe] = packet(PacketType.DATA, values)
            client.peer.send(packed[recipe])

    async def _beat(self) -> None:
        """Send the last state repeatedly while there are no updates."""
        loop = asyncio.get_running_loop()
        while True:
            await asyncio.sleep(HEARTBEAT)
            if loop.time() - self._published >= HEARTBEAT:
                self._publish(to_all=True)


@final
class _Client:
    """A connection, with its version and recipes."""

    def __init__(self, box: UrControlBox, peer: Peer, claims: InputClaims) -> None:
        self._box = box
        self.peer = peer
        self._claims = claims
        self._version = VERSIONS[0]
        self._outputs: OutputRecipe | None = None
        self._rate = VERSION_1_RATE
        self._inputs: dict[int, InputRecipe] = {}
        self._is_started = False
        self._step = -1
        self._slow_since = math.inf

    @property
    def outputs(self) -> OutputRecipe | None:
        """Recipe of the packets that the client currently receives."""
        return self._outputs if self._is_started else None

    def is_due(self, time: float) -> bool:
        """Return whether the client's next period has begun at a simulated time [s]."""
        step = math.floor(time * self._rate + 1e-6)
        is_due = step != self._step
        self._step = step
        return is_due

    def is_slow(self, now: float) -> bool:
        """Return whether the client reads too slowly; disconnect it after a timeout."""
        if self.peer.owed <= MAX_UNREAD:
            self._slow_since = math.inf
            return False
        self._slow_since = min(self._slow_since, now)
        if now - self._slow_since > SLOW_TIMEOUT:
            logger.warning("RTDE: %s does not read: it is dropped", self.peer.address)
            self.peer.drop()
        return True

    async def serve(self) -> None:
        """Answer packets until the client disconnects or violates the protocol."""
        buffer = PacketBuffer()
        while data := await self.peer.reader.read(_CHUNK):
            try:
                for kind, payload in buffer.feed(data):
                    with self.peer.account.working():
                        self._take(kind, payload)
                    await self.peer.account.admit()
            except TransportError as error:
                logger.warning("RTDE: %s: %s", self.peer.address, error)
                self._tell(str(error))
                await self.peer.close()
                return

    def _take(self, kind: int, payload: bytes) -> None:
        match kind:
            case PacketType.DATA:
                self._execute(payload)
            case PacketType.PROTOCOL_VERSION:
                self._choose_version(payload)
            case PacketType.CONTROL_VERSION:
                version = _CONTROL_VERSION.pack(*self._box.version, 0)
                self._reply(PacketType.CONTROL_VERSION, version)
            case PacketType.SETUP_OUTPUTS:
                self._setup_outputs(payload)
            case PacketType.SETUP_INPUTS:
                self._setup_inputs(payload)
            case PacketType.START | PacketType.PAUSE:
                self._is_started = kind == PacketType.START
                self._reply(PacketType(kind), b"\1")
            case PacketType.TEXT:
                logger.info("RTDE: %s: %r", self.peer.address, payload)
            case _:
                self._tell(f"unknown packet type {kind}")

    def _choose_version(self, payload: bytes) -> None:
        accepted = (
            len(payload) == _VERSION.size and _VERSION.unpack(payload)[0] in VERSIONS
        )
        if accepted:
            self._version = _VERSION.unpack(payload)[0]
        self._reply(PacketType.PROTOCOL_VERSION, bytes((accepted,)))

    def _setup_outputs(self, payload: bytes) -> None:
        """Set the client's output fields; if a field is unknown, change nothing."""
        rate, recipe_id = VERSION_1_RATE, None
        if self._version > 1:
            if len(payload) < _FREQUENCY.size:
                raise TransportError("a setup of outputs must begin with a frequency")
            rate = _FREQUENCY.unpack_from(payload)[0]
            payload, recipe_id = payload[_FREQUENCY.size :], 1
        names = field_names(payload)
        types = output_types(names)
        is_known = bool(names) and NOT_FOUND not in types
        if is_known:
            self._outputs = OutputRecipe(names, recipe_id=recipe_id)
            self._rate = rate if 0.0 < rate < self._box.rate else self._box.rate
            self._step = -1
        reply = b"" if recipe_id is None else bytes((recipe_id if is_known else 0,))
        self._reply(PacketType.SETUP_OUTPUTS, reply + _joined(types))

    def _setup_inputs(self, payload: bytes) -> None:
        """Add an input recipe; the answer is number 0 if a field is not available."""
        names = field_names(payload)
        if len(self._inputs) >= MAX_RECIPES:
            raise TransportError(f"more than {MAX_RECIPES} input recipes")
        types = self._claims.claim(names, self)
        number = 0
        if names and not {NOT_FOUND, IN_USE} & set(types):
            number = len(self._inputs) + 1
            self._inputs[number] = InputRecipe(names)
        self._reply(PacketType.SETUP_INPUTS, bytes((number,)) + _joined(types))

    def _execute(self, payload: bytes) -> None:
        recipe = self._inputs.get(payload[0]) if payload else None
        if recipe is None:
            self._tell("data for an input recipe that was not set up")
            return
        try:
            recipe.execute(payload[1:], self._box)
        except TransportError as error:
            self._tell(str(error))

    def _reply(self, kind: PacketType, payload: bytes) -> None:
        self.peer.send(packet(kind, payload))

    def _tell(self, text: str) -> None:
        self.peer.send(text_packet(text, Level.ERROR, self._version))


def _joined(types: tuple[str, ...]) -> bytes:
    return ",".join(types or (NOT_FOUND,)).encode()
