"""The ports of the client interfaces, which send packets and accept programs."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from typing import TYPE_CHECKING, Final, final

from tool0.errors import TransportError
from tool0.ur.client_interface import robot_messages
from tool0.ur.client_interface.realtime import realtime_packet
from tool0.ur.client_interface.robot_state import robot_state
from tool0.ur.client_interface.scripts import ScriptReader
from tool0.ur.client_interface.uploads import Uploads
from tool0.ur.listening import REQUEST_COST, Peer, Port, Serve
from tool0.ur.messages import Message, MessageKind

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox

PRIMARY, SECONDARY, REALTIME = 30001, 30002, 30003
READ_ONLY: Final = 10
"""Offset from the number of each port to the number of its read-only counterpart, which
accepts no programs."""
STATE_PERIOD: Final = 0.1
"""Period of the robot's state on the primary and secondary interfaces, and on all
interfaces while simulated time does not advance [s]."""
MAX_BEHIND: Final = 1 << 16
"""Amount of unread data above which no more data is sent to a client [bytes]. Many
clients only send programs and never read."""
BUILD_DATE: Final = "01-01-2024, 00:00:00"
_SCRIPT_COST: Final = 5e-3
"""Processor time for compiling and starting a program [s]."""
_CHUNK: Final = 1 << 16


@final
class ClientInterface:
    """The primary, secondary and real-time interfaces of a control box."""

    def __init__(self, box: UrControlBox) -> None:
        self._box = box
        self._uploads = Uploads(box)
        self._ports = {
            number + offset: Port(name, self._serving(number, is_open=not offset))
            for number, name in (
                (PRIMARY, "primary interface"),
                (SECONDARY, "secondary interface"),
                (REALTIME, "real-time interface"),
            )
            for offset in (0, READ_ONLY)
        }
        self._n_states = self._n_realtime = -1
        self._safety_mode = box.state.safety_mode
        self._program = ""
        self._is_quiet = True
        self._heart: asyncio.Task[None] | None = None

    async def start(self, host: str, port_base: int) -> None:
        """Open the ports and start to send data.

        Raises:
            TransportError: If a port is in use.
        """
        for number, port in self._ports.items():
            await port.listen(host, port_base + number)
        self._box.when_shown.add(self._show)
        self._box.messages.listeners.add(self._tell)
        self._heart = asyncio.create_task(self._beat())

    async def close(self) -> None:
        """Close the ports and end the secondary programs."""
        self._box.when_shown.discard(self._show)
        self._box.messages.listeners.discard(self._tell)
        if self._heart is not None:
            self._heart.cancel()
        for port in self._ports.values():
            await port.close()
        await self._uploads.close()

    @property
    def n_clients(self) -> int:
        """Number of clients."""
        return sum(len(port.peers) for port in self._ports.values())

    # ---- from clients ---------------------------------------------------------------

    def _serving(self, number: int, *, is_open: bool) -> Serve:
        async def serve(peer: Peer) -> None:
            if number != REALTIME:
                version = robot_messages.version_message(self._box.version, BUILD_DATE)
                peer.send(version + robot_state(self._box, is_first=True))
            reader = ScriptReader()
            while data := await peer.reader.read(_CHUNK):
                await peer.account.pay(REQUEST_COST)
                if not is_open:
                    continue
                try:
                    for script in reader.read(data):
                        self._uploads.put(script)
                        await peer.account.pay(_SCRIPT_COST)
                except TransportError as error:
                    self._box.report(error)
                    return
            if reader.unfinished:
                self._box.report(
                    TransportError(
                        f"{reader.unfinished}: not started, since the connection ended "
                        "before its 'end'"
                    )
                )

        return serve

    # ---- to clients -----------------------------------------------------------------

    def _peers(self, *numbers: int) -> list[Peer]:
        return [
            peer
            for number in numbers
            for offset in (0, READ_ONLY)
            for peer in self._ports[number + offset].peers
        ]

    def _show(self) -> None:
        """Send the packets that are due at an update."""
        box = self._box
        if box.state.safety_mode is not self._safety_mode:
            self._safety_mode = box.state.safety_mode
            self._send(robot_messages.safety_message(box.time, self._safety_mode))
            self._send_state()
        n_states = _periods(box.time, STATE_PERIOD)
        if n_states != self._n_states:
            self._n_states = n_states
            self._send_state()
        n_realtime = _periods(box.time, 1.0 / box.rate)
        if n_realtime != self._n_realtime:
            self._n_realtime = n_realtime
            self._send_realtime()
        self._is_quiet = False

    async def _beat(self) -> None:
        """Keep sending the state while simulated time does not advance."""
        while True:
            await asyncio.sleep(STATE_PERIOD)
            if self._is_quiet:
                self._send_state()
                self._send_realtime()
            self._is_quiet = True

    def _send_state(self) -> None:
        peers = self._peers(PRIMARY, SECONDARY)
        if peers:
            send_to_readers(peers, robot_state(self._box))

    def _send_realtime(self) -> None:
        peers = readers(self._peers(REALTIME))
        if peers:  # clients that only send programs do not read
            send_to_readers(peers, realtime_packet(self._box))

    def _tell(self, message: Message) -> None:
        """Send a message to the clients of the primary interface."""
        time = self._box.time
        match message.kind:
            case MessageKind.TEXT:
                packet = robot_messages.text_message(time, message.text)
            case MessageKind.POPUP:
                packet = robot_messages.popup_message(
                    time, message.title, message.text, is_warning=False, is_error=False
                )
            case MessageKind.ERROR:
                packet = robot_messages.error_message(
                    time, message.text, message.code, is_warning=message.is_warning
                )
            case MessageKind.EXCEPTION:
                packet = robot_messages.exception_message(
                    time, message.place, message.text
                )
            case MessageKind.PROGRAM:
                if message.text:
                    self._program = message.text
                    title = robot_messages.PROGRAM_STARTED
                else:
                    title = robot_messages.PROGRAM_STOPPED
                packet = robot_messages.key_message(time, title, self._program)
        self._send(packet)

    def _send(self, packet: bytes) -> None:
        send_to_readers(self._peers(PRIMARY), packet)


def _periods(time: float, period: float) -> int:
    """Return the number of periods that have passed since time 0."""
    return int(time / period + 1e-6)


def readers(peers: Iterable[Peer]) -> list[Peer]:
    """Return the peers with less than ``MAX_BEHIND`` bytes of unread data."""
    return [peer for peer in peers if peer.owed < MAX_BEHIND]


def send_to_readers(peers: Iterable[Peer], packet: bytes) -> None:
    """Send a packet to the peers with less than ``MAX_BEHIND`` bytes of unread data."""
    for peer in readers(peers):
        peer.send(packet)
