"""A hundred thousand broken packets: the server stays up, and the robot holds."""

from __future__ import annotations

import random
import socket
import struct
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from ur_packets import Packets
from ur_rig import UrRig, ur_rig
from waits import until

PACKETS = 100_000
"""In total, over all ports."""
MAX_GROWTH = 96 << 20
"""Of the memory of the process that serves the ports [bytes]."""
MAX_DRIFT = 2e-3
"""Of the arm's joints [rad]."""
SEED = 19
PACKETS_UNTIL_STARTED = 250
"""Of the real-time interface, at 500 Hz: a program has started and ended by then."""


def rtde(kind: str, body: bytes = b"") -> bytes:
    return struct.pack(">HB", 3 + len(body), ord(kind)) + body


SCRIPTS = (
    b"textmsg(1)\n",
    b"def f():\n  if (1 + 2) * [3][0] == p[0,0,0,0,0,0]:\n    halt\n  end\nend\n",
    b"sec s():\n  set_digital_out(1, True)\nend\n",
    b"def t():\n  thread t():\n    sleep(0.1)\n  end\n  join run t()\nend\n",
    b"global a = get_inverse_kin(p[9,9,9,0,0,0])\n",
)
DASHBOARD = (
    b"robotmode\n",
    b"load ../../etc/passwd\n",
    b"popup " + b"x" * 200 + b"\n",
    b"play\nstop\npause\n",
    b"set operational mode manual\n",
    b"unlock protective stop\n",
    b"addToLog \xff\xfe\n",
)
RTDE = (
    rtde("V", struct.pack(">H", 2)),
    rtde("v"),
    rtde("O", struct.pack(">d", 125.0) + b"timestamp,actual_q"),
    rtde("I", b"input_int_register_30,speed_slider_mask"),
    rtde("S"),
    rtde("P"),
    rtde("U", struct.pack(">Bi", 1, 7)),
    rtde("M", b"\x02hi\x02me\x00"),
)
GRIPPER = (
    b"GET POS\n",
    b"SET ACT 1 GTO 1\n",
    b"SET POS 300 SPE -1\n",
    b"GET " * 50 + b"\n",
    b"SET\n",
)
MODBUS = tuple(
    struct.pack(">HHHB", 1, 0, len(body) + 1, 9) + body
    for body in (
        struct.pack(">BHH", 3, 2000, 6),
        struct.pack(">BHH", 4, 2000, 125),
        struct.pack(">BHHBHHH", 16, 1000, 3, 6, 0x0900, 0xFF, 0xFFFF),
        struct.pack(">BHHHHBH", 23, 2000, 3, 1000, 1, 2, 0),
        struct.pack(">BHH", 3, 0xFFFF, 0xFFFF),
        b"\x55",
    )
)
PORTS = {
    29999: DASHBOARD,
    30001: SCRIPTS,
    30002: SCRIPTS,
    30003: SCRIPTS,
    30004: RTDE,
    63352: GRIPPER,
    502: MODBUS,
}


def broken(chance: random.Random, samples: tuple[bytes, ...]) -> bytes:
    """Return noise, or a packet with some bytes changed, dropped or repeated."""
    if chance.random() < 0.4:
        return chance.randbytes(chance.randint(1, 60))
    packet = bytearray(chance.choice(samples))
    for _ in range(chance.randint(0, 4)):
        k = chance.randrange(len(packet))
        match chance.randrange(3):
            case 0:
                packet[k] = chance.randrange(256)
            case 1:
                packet[k:] = packet[k + 1 :] or b"\0"
            case 2:
                packet[k:k] = packet[: chance.randint(1, 30)]
    return bytes(packet)


def attack(rig: UrRig, port: int, count: int) -> None:
    """Send broken packets to a port, and connect again whenever it has hung up."""
    chance = random.Random(SEED * port)
    connection: socket.socket | None = None
    for _ in range(count):
        if connection is None or chance.random() < 0.02:
            if connection is not None:
                connection.close()
            connection = rig.connect(port)
            connection.settimeout(None)  # with a timeout, recv below would wait
        try:
            connection.sendall(broken(chance, PORTS[port]))
            while connection.recv(1 << 16, socket.MSG_DONTWAIT):
                pass
            raise ConnectionError
        except BlockingIOError:
            continue  # it has read all there is
        except OSError:
            connection.close()
            connection = None
    if connection is not None:
        connection.close()


def memory(pid: int) -> int:
    """Return the resident memory of a process [bytes]."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * 4096


@pytest.fixture
def rig() -> Iterator[UrRig]:
    with ur_rig() as rig:
        yield rig


def test_broken_packets_on_every_port_change_nothing(rig: UrRig) -> None:
    print(f"seed {SEED}")
    pid = rig.controller.pid
    assert pid is not None
    before, q = memory(pid), np.array(list(rig.robot.arm.joints.values()))
    run_together(
        *(
            lambda port=port: attack(rig, port, PACKETS // len(PORTS) + 1)
            for port in PORTS
        )
    )
    assert rig.controller.pid == pid, "the process has died"
    assert memory(pid) - before < MAX_GROWTH
    check_that_good_clients_are_served(rig)
    rig.robot.run(1.0)  # controllers of efforts sag when a program returns the arm
    drift = np.abs(np.array(list(rig.robot.arm.joints.values())) - q).max()
    assert drift < MAX_DRIFT


def run_together(*tasks: Callable[[], None]) -> None:
    """Run tasks in threads; raise what one of them raised."""
    failures: list[BaseException] = []

    def guarded(task: Callable[[], None]) -> None:
        try:
            task()
        except BaseException as error:
            failures.append(error)

    threads = [threading.Thread(target=guarded, args=(task,)) for task in tasks]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if failures:
        raise failures[0]


def check_that_good_clients_are_served(rig: UrRig) -> None:
    for check in (
        ask_the_dashboard,
        read_the_state,
        send_a_program,
        greet_rtde,
        ask_the_gripper,
        read_modbus,
    ):
        until_accepted(lambda check=check: check(rig))


def until_accepted(task: Callable[[], None]) -> None:
    """Try again while the port still works off what broken clients have sent."""
    refusal: OSError | None = None

    def is_accepted() -> bool:
        nonlocal refusal
        try:
            task()
        except OSError as error:
            refusal = error
            return False
        return True

    until(is_accepted, lambda: f"an answer, not {refusal!r}", period=0.0)


def ask_the_dashboard(rig: UrRig) -> None:
    dashboard = rig.dashboard()
    try:
        if not dashboard.greeting:
            raise ConnectionError
        dashboard.ask("stop")
        assert dashboard.ask("robotmode") == "Robotmode: RUNNING"
    finally:
        dashboard.close()


def read_the_state(rig: UrRig) -> None:
    for port in (30001, 30002):
        with rig.connect(port) as connection:
            state = next(Packets(connection).states())
            assert state["mode"]["robot_mode"] == 7


def send_a_program(rig: UrRig) -> None:
    """Send it again if one of the programs before it was the newer one, or a stop."""
    with rig.connect(30003) as connection:
        connection.sendall(b"set_digital_out(7, True)\n")
        packets = Packets(connection)
        for _ in range(PACKETS_UNTIL_STARTED):
            if int(packets.realtime()["digital_outputs"]) & 1 << 7:
                return
    raise ConnectionError


def greet_rtde(rig: UrRig) -> None:
    assert asked(rig, 30004, RTDE[0]) == rtde("V", b"\1")


def ask_the_gripper(rig: UrRig) -> None:
    assert asked(rig, 63352, b"GET STA\n").startswith(b"STA ")


def read_modbus(rig: UrRig) -> None:
    assert asked(rig, 502, MODBUS[0])[7] == 3


def asked(rig: UrRig, port: int, packet: bytes) -> bytes:
    with rig.connect(port) as connection:
        connection.sendall(packet)
        answer = connection.recv(64)
    if not answer:
        raise ConnectionError
    return answer
