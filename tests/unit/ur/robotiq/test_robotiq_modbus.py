"""Modbus, with pymodbus as its client and the frames of Robotiq's manuals."""

from __future__ import annotations

import os
import random
import socket
import stat
import struct
from collections.abc import Iterator
from pathlib import Path

import pytest
from pymodbus.client import ModbusSerialClient, ModbusTcpClient
from robotiq_rig import LONG, ServedGripper, serving_gripper
from waits import until

import tool0
from tool0.ur.robotiq.modbus import respond
from tool0.ur.robotiq.modbus_rtu import RtuReceiver, checksum

COMMAND, STATUS = 1000, 2000
GO = 0x0900


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedGripper]:
    folder: Path = tmp_path_factory.mktemp("robotiq")
    with (
        tool0.bringup(initial_pose="ready", speed=4.0) as robot,
        serving_gripper(robot, folder) as served,
    ):
        yield served


@pytest.fixture
def tcp(served: ServedGripper) -> Iterator[ModbusTcpClient]:
    port = served.interface.modbus_tcp.number
    with ModbusTcpClient(served.host, port=port, timeout=LONG) as client:
        yield client


@pytest.fixture
def serial(served: ServedGripper) -> Iterator[ModbusSerialClient]:
    path = str(served.interface.serial_port)
    with ModbusSerialClient(path, baudrate=115200, timeout=LONG) as client:
        yield client


@pytest.mark.slow
def test_pymodbus_activates_and_moves_it_over_tcp(tcp: ModbusTcpClient) -> None:
    operate(tcp)


@pytest.mark.slow
def test_pymodbus_activates_and_moves_it_over_a_serial_port(
    serial: ModbusSerialClient,
) -> None:
    operate(serial)


def operate(client: ModbusTcpClient | ModbusSerialClient) -> None:
    """Activate, close and open as the manual's example does."""

    def read(count: int = 3) -> list[int]:
        return client.read_holding_registers(STATUS, count=count, device_id=9).registers

    def write(*values: int, address: int = COMMAND) -> None:
        answer = client.write_registers(address, list(values), device_id=9)
        assert not answer.isError()

    write(0, 0, 0)
    assert read()[:2] == [0, 0]
    write(0x0100, 0, 0)
    assert read(1) == [0x1100]
    until(lambda: read(1) == [0x3100], "it is activated", period=0.0)
    write(GO, 0x00FF, 0xFFFF)
    until(lambda: read(1) != [0x3900], "it has closed", period=0.0)
    status, request, position = read()
    assert (status, request, position >> 8) == (0xF900, 0x00FF, 230)
    write(0x0000, 0xFF00, address=COMMAND + 1)  # open, the action as it was
    until(lambda: read()[2] >> 8 == 3, "it has opened", period=0.0)
    both = client.readwrite_registers(
        read_address=STATUS,
        read_count=6,
        write_address=COMMAND + 2,
        values=[0x8040],
        device_id=9,
    )
    assert both.registers[3:] == [0, 0, 0]
    assert client.read_input_registers(COMMAND, count=3, device_id=9).registers == [
        *(GO, 0, 0x8040)
    ]


def test_registers_start_at_zero_too_for_tcp(tcp: ModbusTcpClient) -> None:
    tcp.write_registers(0, [0x0000, 0x0000, 0x1234])
    assert tcp.read_holding_registers(COMMAND, count=3).registers == [0, 0, 0x1234]
    assert tcp.read_input_registers(0, count=1).registers == [0]
    assert tcp.write_register(2, 0x5678).registers == [0x5678]
    assert tcp.read_holding_registers(0, count=3).registers == [0, 0, 0x5678]


@pytest.mark.parametrize(
    ("request_", "response"),
    [
        ("01 0000 0001", "81 01"),  # coils
        ("2b 0e01 00", "ab 01"),
        ("03 07cf 0001", "83 02"),
        ("03 07d0 0009", "83 02"),
        ("04 0000 0001", "84 02"),
        ("03 07d0 0000", "83 03"),
        ("03 07d0 007e", "83 03"),
        ("03 07d0", "83 03"),
        ("06 07d0 0001", "86 02"),
        ("06 ffff 0001", "86 02"),
        ("10 03e8 0001 02 00", "90 03"),
        ("10 03e8 0001 03 000000", "90 03"),
        ("10 03e8 0000 00", "90 03"),
        ("10 03ef 0002 04 00000000", "90 02"),
        ("17 03e8 0001 07d0 0001 02 0000", "97 02"),
        ("17 0000 0001 03e8 0001 02 0100", "97 02"),
        ("17 07d0 0001 03e8 0001 02", "97 03"),
        ("03", "83 03"),
        ("10", "90 03"),
    ],
)
def test_wrong_requests_are_refused_by_the_exceptions_of_modbus(
    served: ServedGripper, request_: str, response: str
) -> None:
    served.do(served.gripper.reset)
    before = served.gripper.command
    data = bytes.fromhex(request_)
    assert served.do(lambda: respond(served.gripper, data)) == bytes.fromhex(response)
    assert served.gripper.command == before


@pytest.mark.parametrize(
    "frame",
    [  # of the manuals, with their checksums
        *("09 10 03E8 0003 06 0000 0000 0000 7330", "09 10 03E8 0003 0130"),
        *("09 03 07D0 0001 85CF", "09 03 02 1100 55D5", "09 04 07D0 0003 B1CE"),
        *("09 10 03E8 0003 06 0900 00FF FFFF 4229", "09 10 03E9 0002 9130"),
    ],
)
def test_checksums_are_those_of_the_manual(frame: str) -> None:
    data = bytes.fromhex(frame)
    assert checksum(data[:-2]) == data[-2:]


def framed(text: str) -> bytes:
    data = bytes.fromhex(text)
    return data + checksum(data)


def test_serial_frames_are_found_among_others_and_garbage(
    served: ServedGripper,
) -> None:
    receiver = RtuReceiver(served.gripper)
    read = framed("09 03 07d1 0001")
    answer = framed("09 03 02 0000")

    def take(data: bytes) -> bytes:
        return served.do(lambda: receiver.take(data))

    def pause() -> bytes:
        return served.do(receiver.pause)

    served.do(lambda: served.gripper.change(position=0, go_to=False))
    assert b"".join(take(read[k : k + 1]) for k in range(len(read))) == answer
    assert take(read + read) == 2 * answer
    assert take(framed("05 03 07d1 0001") + read) == answer  # another device's
    assert take(framed("00 06 03ea 2233")) == b""  # a broadcast
    assert served.gripper.command.speed == 0x22
    assert take(b"\x55\xaa\x03\x00" + read) + pause() == answer
    assert take(read[:-1] + b"\x00") + take(read) + pause() == answer
    assert take(b"\x09\x10\x03\xe8\x00\x7b\xf6") + take(read) + pause() == answer
    assert take(framed("09 08 0000 1234")) + pause() == framed("09 88 01")
    assert take(read[:4]) + pause() == b""
    assert take(read) == answer


def test_a_serial_port_outlives_its_clients(served: ServedGripper) -> None:
    path = served.interface.serial_port
    assert stat.S_ISCHR(path.stat().st_mode)
    for _ in range(2):
        with ModbusSerialClient(str(path), timeout=LONG) as client:
            found = client.read_holding_registers(STATUS, count=3, device_id=9)
            assert len(found.registers) == 3
            assert client.read_holding_registers(0, device_id=9).isError()


def test_units_are_ignored_over_tcp_and_frames_come_in_any_pieces(
    served: ServedGripper,
) -> None:
    address = (served.host, served.interface.modbus_tcp.number)
    with socket.create_connection(address, timeout=LONG) as client:
        frames = b"".join(
            struct.pack(">HHHBBHH", number, 0, 6, unit, 3, STATUS, 1)
            for number, unit in enumerate((0, 1, 2, 9, 255))
        )
        for k in range(0, len(frames), 5):
            client.sendall(frames[k : k + 5])
        received = b""
        while len(received) < 5 * 11:
            received += client.recv(1024)
        assert received[6::11] == bytes([0, 1, 2, 9, 255])
        client.sendall(b"GET POS\nGET POS\n")  # not Modbus
        assert client.recv(1024) == b""


def test_garbage_harms_nobody(served: ServedGripper, tcp: ModbusTcpClient) -> None:
    chance = random.Random(5)
    functions = [3, 4, 6, 16, 23, 8, 0, 255]

    def data(most: int) -> bytes:
        head = bytes([chance.choice(functions)])
        return head + chance.randbytes(chance.randrange(most))

    def parse() -> None:
        receiver = RtuReceiver(served.gripper)
        for _ in range(10_000):
            assert len(respond(served.gripper, data(12), is_tcp=True)) >= 2
            receiver.take(b"\x09" + data(20))
        receiver.pause()

    served.do(parse)
    address = (served.host, served.interface.modbus_tcp.number)
    for _ in range(20):
        with socket.create_connection(address, timeout=LONG) as client:
            client.sendall(chance.randbytes(300))
    terminal = os.open(served.interface.serial_port, os.O_RDWR | os.O_NOCTTY)
    os.write(terminal, chance.randbytes(3000))
    os.close(terminal)
    assert len(tcp.read_holding_registers(STATUS, count=3).registers) == 3


def test_without_power_nothing_answers(
    served: ServedGripper, tcp: ModbusTcpClient
) -> None:
    box = served.robot.arm.control_box
    box.power_off()
    served.wait_for_update(lambda: not served.gripper.is_powered)
    assert tcp.read_holding_registers(STATUS, count=3).exception_code == 11
    receiver = RtuReceiver(served.gripper)
    assert served.do(lambda: receiver.take(framed("09 03 07d0 0001"))) == b""
    box.release_brakes()
    box.play()
    served.wait_for_update(lambda: served.gripper.is_powered)


@pytest.mark.slow
def test_the_serial_port_is_removed_at_the_end(tmp_path: Path) -> None:
    with (
        tool0.bringup(gripper="hande", speed=4.0) as robot,
        serving_gripper(robot, tmp_path) as served,
    ):
        path = served.interface.serial_port
        assert path.is_symlink()
    assert not path.is_symlink()
