"""Broken packets on every port of a UR: the server stays up, and the robot holds.

The packets are those of real clients, changed, cut, joined or sent in pieces.  Clients
leave in every way.  The server answers or hangs up, and prints no exception.
"""

from __future__ import annotations

import random
import socket
import struct
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

import numpy as np
import pytest
from fuzzing import SCALE, SEED, changed
from ur_packets import Packets
from ur_rig import UrRig, ur_rig
from waits import until

PACKETS: Final = 5_000 * SCALE
"""In total, over all ports."""
MAX_GROWTH: Final = 96 << 20
"""Of the memory of the process that serves the ports [bytes]."""
MAX_DRIFT: Final = 2e-3
"""Of the arm's joints [rad]."""
HANG_UP: Final = 30.0
"""Longest time until the server ends a connection of which it will read no more, on a
busy machine [wall s]."""
PACKETS_UNTIL_STARTED: Final = 250
"""Of the real-time interface, at 500 Hz: a program has started and ended by then."""


def rtde(kind: str, body: bytes = b"") -> bytes:
    return struct.pack(">HB", 3 + len(body), ord(kind)) + body


SCRIPTS: Final = (
    b"textmsg(1)\n",
    b"def f():\n  if (1 + 2) * [3][0] == p[0,0,0,0,0,0]:\n    halt\n  end\nend\n",
    b"sec s():\n  set_digital_out(1, True)\nend\n",
    b"def t():\n  thread t():\n    sleep(0.1)\n  end\n  join run t()\nend\n",
    b"global a = get_inverse_kin(p[9,9,9,0,0,0])\n",
    b"def i():\n  interpreter_mode()\nend\ni()\n",
    b"def w():\n  while True:\n    x = get_actual_tcp_pose()\n  end\nend\n",
    b"stop program\n",
    b"set unlock protective stop\n",
    b"set robotmode run\npower on\n",
    b'popup("\xe4", blocking=True)\n',
    b"def unfinished():\n  if True:\n",
)
DASHBOARD: Final = (
    b"robotmode\n",
    b"load ../../etc/passwd\n",
    b"popup " + b"x" * 200 + b"\n",
    b"play\nstop\npause\n",
    b"set operational mode manual\n",
    b"unlock protective stop\n",
    b"addToLog \xff\xfe\n",
    b"load a.urp\r\nget loaded program\r\nprogramState\r\nisProgramSaved\r\n",
    b"safetystatus\nget serial number\nget robot model\nPolyscopeVersion\n",
    b"close popup\nclose safety popup\nquit\n",
    b"saveLog\n",
)
RTDE: Final = (
    rtde("V", struct.pack(">H", 2)),
    rtde("V", struct.pack(">H", 1)),
    rtde("v"),
    rtde("O", struct.pack(">d", 125.0) + b"timestamp,actual_q"),
    rtde("O", b"timestamp,target_q,output_int_register_30,actual_digital_input_bits"),
    rtde("I", b"input_int_register_30,speed_slider_mask"),
    rtde("I", b"external_force_torque,standard_digital_output"),
    rtde("S"),
    rtde("P"),
    rtde("U", struct.pack(">Bi", 1, 7)),
    rtde("U", struct.pack(">B6dB", 2, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 3)),
    rtde("M", b"\x02hi\x02me\x00"),
    rtde("V", struct.pack(">H", 2))
    + rtde("O", struct.pack(">d", 500.0) + b"timestamp,robot_mode")
    + rtde("S"),
)
INTERPRETER: Final = (
    b"x = 1\n",
    b"def double(x): return 2 * x end\n",
    b"textmsg(double(4)) set_flag(1, True)\n",
    b"statelastexecuted\nstateunexecuted\nstatelastinterpreted\nstatelastcleared\n",
    b"skipbuffer\nabort\n",
    b"clear_interpreter()\n",
    b"end_interpreter()\n",
    b'popup("\xff")\r\n',
)
GRIPPER: Final = (
    b"GET POS\n",
    b"GET OBJ",
    b"SET ACT 1 GTO 1\n",
    b"SET POS 300 SPE -1\n",
    b"SET POS 200 SPE 255 FOR 10\n",
    b"GET " * 50 + b"\n",
    b"SET\n",
)
MODBUS: Final = tuple(
    struct.pack(">HHHB", 1, 0, len(body) + 1, 9) + body
    for body in (
        struct.pack(">BHH", 3, 2000, 6),
        struct.pack(">BHH", 4, 2000, 125),
        struct.pack(">BHH", 6, 1000, 0x0900),
        struct.pack(">BHHBHHH", 16, 1000, 3, 6, 0x0900, 0xFF, 0xFFFF),
        struct.pack(">BHHHHBH", 23, 2000, 3, 1000, 1, 2, 0),
        struct.pack(">BHH", 3, 0xFFFF, 0xFFFF),
        b"\x55",
    )
)
MODBUS_PORT: Final = 502
PORTS: Final = {
    29999: DASHBOARD,
    **dict.fromkeys((30001, 30002, 30003, 30011, 30012, 30013), SCRIPTS),
    30004: RTDE,
    30020: INTERPRETER,
    63352: GRIPPER,
    MODBUS_PORT: MODBUS,
}
"""All that a UR listens on, with what its clients send."""


def broken(chance: random.Random, samples: tuple[bytes, ...]) -> bytes:
    """Return noise, or packets with something changed, dropped or repeated."""
    if chance.random() < 0.2:
        return chance.randbytes(chance.randint(1, 60))
    packet = b"".join(
        chance.choice(samples) for _ in range(chance.choice((1, 1, 2, 5)))
    )
    match chance.randrange(6):
        case 0:
            return changed(packet, chance) or b"\0"
        case 1:
            return packet[: chance.randint(1, len(packet))]
        case 2:  # a length, a type, or a line's end
            k = chance.randrange(len(packet))
            odd = bytes((chance.choice((0, 1, 2, 10, 13, 127, 128, 255)),))
            return packet[:k] + odd + packet[k + 1 :]
        case 3:
            k = chance.randrange(len(packet))
            return packet[:k] + b"\xc3\x28\xff\xed\xa0\x80" + packet[k:]
        case 4:
            k = chance.randrange(len(packet))
            return packet[:k] + packet[: chance.randint(1, 300)] + packet[k:]
    return packet


class Attacker:
    """Sends broken packets to a port, and connects again whenever it has hung up."""

    def __init__(self, rig: UrRig, port: int, *, number: int) -> None:
        self._rig, self._port, self._samples = rig, port, PORTS[number]
        self._chance = random.Random(f"{SEED}.{number}")
        self._connection: socket.socket | None = None

    def attack(self, count: int) -> None:
        """Send packets, and leave."""
        for _ in range(count):
            if self._connection is None:
                self._connection = self._rig.connect(self._port)
                self._connection.settimeout(HANG_UP)
            try:
                self._send(broken(self._chance, self._samples))
                self._read()
                if self._chance.random() < 0.02:
                    self._leave()
            except TimeoutError:
                raise AssertionError(f"port {self._port} hangs") from None
            except OSError:
                self._close()
        self._close()

    def _send(self, packet: bytes) -> None:
        """Send a packet, in one piece or in several."""
        assert self._connection is not None
        cut = self._chance.randrange(len(packet)) if self._chance.random() < 0.2 else 0
        for piece in (packet[:cut], packet[cut:]):
            self._connection.sendall(piece)

    def _read(self) -> None:
        """Read what has arrived.

        Raises:
            ConnectionError: The server has hung up.
        """
        assert self._connection is not None
        self._connection.setblocking(False)
        try:
            while self._connection.recv(1 << 16):
                pass
            raise ConnectionError
        except BlockingIOError:
            pass
        finally:
            self._connection.settimeout(HANG_UP)

    def _leave(self) -> None:
        """End the connection: half of it, all of it, or as a program that crashes."""
        assert self._connection is not None
        match self._chance.randrange(3):
            case 0:
                self._connection.shutdown(socket.SHUT_WR)
                while self._connection.recv(1 << 16):
                    pass
            case 1:
                at_once = struct.pack("ii", 1, 0)
                self._connection.setsockopt(
                    socket.SOL_SOCKET, socket.SO_LINGER, at_once
                )
        self._close()

    def _close(self) -> None:
        if self._connection is not None:
            self._connection.close()
            self._connection = None


def memory(pid: int) -> int:
    """Return the resident memory of a process [bytes]."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * 4096


@pytest.fixture
def rig() -> Iterator[UrRig]:
    with ur_rig() as rig:
        yield rig


@pytest.mark.timeout(300 + 60 * SCALE)
def test_broken_packets_on_every_port_change_nothing(
    rig: UrRig, caplog: pytest.LogCaptureFixture
) -> None:
    pid = rig.controller.pid
    assert pid is not None
    before, q = memory(pid), np.array(list(rig.robot.arm.joints.values()))
    run_together(
        *(
            lambda port=port: Attacker(rig, port_of(rig, port), number=port).attack(
                -(-PACKETS // len(PORTS))
            )
            for port in PORTS
        )
    )
    growth = memory(pid) - before
    print(f"{PACKETS} packets on {len(PORTS)} ports, {growth / 2**20:.1f} MiB more")
    assert rig.controller.pid == pid, "the process has died"
    assert growth < MAX_GROWTH
    check_that_good_clients_are_served(rig)
    rig.robot.run(1.0)  # controllers of efforts sag when a program returns the arm
    drift = np.abs(np.array(list(rig.robot.arm.joints.values())) - q).max()
    assert drift < MAX_DRIFT
    said = [record.getMessage() for record in caplog.records]
    raw = [k for k, line in enumerate(said) if "Traceback" in line]
    assert not raw, "\n".join(said[raw[0] - 2 : raw[0] + 40])


def port_of(rig: UrRig, number: int) -> int:
    """Return where the port with UR's number is: users may not listen on port 502."""
    if number != MODBUS_PORT:
        return number
    (arm,) = rig.controller.wait().values()
    assert arm.modbus_port is not None
    return arm.modbus_port


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
    assert asked(rig, port_of(rig, MODBUS_PORT), MODBUS[0])[7] == 3


def asked(rig: UrRig, port: int, packet: bytes) -> bytes:
    with rig.connect(port) as connection:
        connection.sendall(packet)
        answer = connection.recv(64)
    if not answer:
        raise ConnectionError
    return answer
