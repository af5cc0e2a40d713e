"""Clients of a robot's interfaces, against servers that behave and that do not."""

from __future__ import annotations

import socket
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

import pytest
from raises_naming import raises_naming
from waits import until

from tool0.devices.dashboard_client import DashboardClient
from tool0.devices.gripper_links import UrcapLink
from tool0.devices.polled_gripper import PolledGripper
from tool0.devices.robotiq_registers import CommandRegisters, ObjectStatus
from tool0.devices.rtde_client import RtdeClient
from tool0.devices.rtde_packets import PacketBuffer, PacketType, packet
from tool0.errors import ControlError, TransportError

Serve = Callable[[socket.socket], None]


@contextmanager
def server(serve: Serve) -> Iterator[int]:
    """Serve one connection after the other in a thread; yield the port."""
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def run() -> None:
            while True:
                try:
                    connection, _ = listener.accept()
                except OSError:
                    return
                with connection, suppress(OSError):
                    serve(connection)

        threading.Thread(target=run, daemon=True).start()
        yield listener.getsockname()[1]
        listener.shutdown(socket.SHUT_RDWR)


def rtde(types: str, packages: bytes) -> Serve:
    """Return a controller that answers each set-up with ``types``."""

    def serve(connection: socket.socket) -> None:
        buffer = PacketBuffer()
        while data := connection.recv(4096):
            for kind, _ in buffer.feed(data):
                answer = {
                    PacketType.PROTOCOL_VERSION: b"\x01",
                    PacketType.CONTROL_VERSION: struct.pack(">4I", 5, 11, 0, 1),
                    PacketType.SETUP_OUTPUTS: b"\x07" + types.encode(),
                    PacketType.START: b"\x01",
                }[PacketType(kind)]
                connection.sendall(packet(PacketType(kind), answer))
                if kind == PacketType.START:
                    for k in range(len(packages)):  # in pieces
                        connection.sendall(packages[k : k + 1])
                    return

    return serve


def data(time: float, *q: float) -> bytes:
    return packet(PacketType.DATA, struct.pack(">B7d", 7, time, *q))


def test_packages_come_in_order_whatever_their_pieces() -> None:
    joints = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    sent = data(0.1, *joints) + data(0.2, *joints)
    with server(rtde("DOUBLE,VECTOR6D", sent)) as port:
        client = RtdeClient("127.0.0.1", port, outputs=("timestamp", "actual_q"))
        assert client.version.is_e_series
        assert client.rate == 500.0
        client.start()
        found: list[tuple[float, ...]] = []
        while len(found) < 2:
            found += client.receive(1.0)
        with pytest.raises(TransportError, match="closed the connection"):
            client.receive(5.0)
        client.close()
    assert [package[0] for package in found] == [0.1, 0.2]
    assert found[0][client.columns["actual_q"]] == joints


def test_a_field_that_is_missing_is_named() -> None:
    with (
        server(rtde("DOUBLE,NOT_FOUND", b"")) as port,
        raises_naming(TransportError, "actual_qx", "PolyScope 5.11 is too old"),
    ):
        RtdeClient("127.0.0.1", port, outputs=("timestamp", "actual_qx"))


@pytest.mark.parametrize("answer", [b"", b"\x00", b"HTTP/1.1 400 Bad Request\r\n\r\n"])
def test_a_server_of_something_else_is_no_controller(answer: bytes) -> None:
    def serve(connection: socket.socket) -> None:
        connection.recv(4096)
        connection.sendall(answer)

    with server(serve) as port, pytest.raises(TransportError, match="RTDE of 127"):
        RtdeClient("127.0.0.1", port, outputs=("timestamp",), timeout=0.5)


def test_nobody_at_the_address_is_said() -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    with raises_naming(TransportError, f"127.0.0.1:{port}", "refused"):
        RtdeClient("127.0.0.1", port, outputs=("timestamp",))


def lines(answers: dict[str, str], greeting: str = "Connected\n") -> Serve:
    def serve(connection: socket.socket) -> None:
        connection.sendall(greeting.encode())
        with connection.makefile("rw", newline="\n") as file:
            while line := file.readline():
                if (answer := answers.get(line.strip())) is None:
                    return
                file.write(f"{answer}\n")
                file.flush()

    return serve


def test_the_dashboard_is_asked_again_after_it_was_gone() -> None:
    answers = {"robotmode": "Robotmode: RUNNING", "power on": "Power refused"}
    with server(lines(answers)) as port:
        client = DashboardClient("127.0.0.1", port, timeout=5.0)
        assert client.ask("robotmode") == "Robotmode: RUNNING"
        with raises_naming(TransportError, "does not answer 'quit'"):
            client.ask("quit")
        assert client.ask("robotmode") == "Robotmode: RUNNING"
        with raises_naming(ControlError, "refuses 'power on': Power refused"):
            client.order("power on", "Powering on")
        client.close()


class Gripper:
    """A URCap's socket with the variables of a gripper."""

    def __init__(self) -> None:
        self.values = {"POS": 3, "OBJ": 3, "STA": 3, "FLT": 0}
        self.commands: list[str] = []
        self.has_power = True

    def __call__(self, connection: socket.socket) -> None:
        with connection.makefile("rb") as file:
            while line := file.readline().decode():
                words = line.split()
                if words[0] == "SET":
                    self.commands.append(line.strip())
                    connection.sendall(b"ack")
                elif self.has_power:
                    name = words[1]
                    connection.sendall(f"{name} {self.values[name]}\n".encode())
                else:
                    connection.sendall(b"?")


def test_a_gripper_is_read_and_commanded_once() -> None:
    gripper = Gripper()
    with server(gripper) as port:
        polled = PolledGripper(lambda: UrcapLink("127.0.0.1", port), "gripper")
        until(lambda: polled.reading is not None, "a reading")
        assert polled.problem == ""
        polled.move(200, 255, 100)
        polled.move(200, 255, 100)
        until(lambda: polled.is_sent, "the command")
        assert gripper.commands == ["SET ACT 1 GTO 1 POS 200 SPE 255 FOR 100"]
        gripper.values |= {"POS": 180, "OBJ": 2}
        until(lambda: polled.reading and polled.reading.position == 180, "180")
        assert polled.reading is not None
        assert polled.reading.object_status is ObjectStatus.MET_CLOSING
        gripper.has_power = False
        until(lambda: "no power" in polled.problem, "the loss of power")
        gripper.has_power = True
        until(lambda: polled.problem == "", "power again")
        assert len(gripper.commands) == 1  # nothing is repeated
        polled.close()


def test_the_command_of_a_urcap_has_all_registers() -> None:
    gripper = Gripper()
    with server(gripper) as port:
        link = UrcapLink("127.0.0.1", port)
        link.write(CommandRegisters(activate=True))
        link.close()
    assert gripper.commands == ["SET ACT 1 GTO 0 POS 0 SPE 0 FOR 0"]
