"""The clients of the UR interface's benchmark: ur_rtde, and RTDE through a socket.

Times are read from the monotonic clock, which all processes of a machine share.  Each
role prints one JSON value.
"""

from __future__ import annotations

import json
import socket
import struct
import sys
import time

PORT = 30004
VERSION, START, OUTPUTS, DATA = 86, 83, 79, 85
"""Packet types of RTDE."""
FIELDS = "timestamp,actual_q,actual_qd,actual_TCP_pose,actual_TCP_speed,robot_mode"
SKIPPED = 250
"""Number of first samples that are not counted."""
STEP = 0.02
"""Amplitude of the targets [rad]."""
PERIOD = 0.002
"""Period of the stream of targets [s]."""
EVERY = 50
"""Number of commands between two changes of the target."""


def samples(host: str, count: str) -> list[tuple[float, float]]:
    """Return the time stamps [s] and the reception times [s] of RTDE's samples."""
    with socket.create_connection((host, PORT)) as connection:
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        packets = connection.makefile("rb")

        def ask(kind: int, payload: bytes) -> None:
            connection.sendall(struct.pack(">HB", len(payload) + 3, kind) + payload)
            size, answer = struct.unpack(">HB", packets.read(3))
            packets.read(size - 3)
            assert answer == kind, answer

        ask(VERSION, struct.pack(">H", 2))
        ask(OUTPUTS, struct.pack(">d", 500.0) + FIELDS.encode())
        ask(START, b"")
        received = []
        while len(received) < SKIPPED + int(count):
            size, kind = struct.unpack(">HB", packets.read(3))
            payload = packets.read(size - 3)
            if kind == DATA:
                stamp = struct.unpack_from(">d", payload, 1)[0]
                received.append((stamp, time.monotonic()))
        return received[SKIPPED:]


def servo(host: str, count: str) -> list[float]:
    """Stream targets with servoJ, and return the times of changed targets [s]."""
    from rtde_control import RTDEControlInterface
    from rtde_receive import RTDEReceiveInterface

    control, receive = RTDEControlInterface(host), RTDEReceiveInterface(host)
    q = receive.getActualQ()
    sent, due = [], time.monotonic()
    for k in range(EVERY * (int(count) + 1)):
        if k % EVERY == 0:
            q[5] += STEP if k // EVERY % 2 else -STEP
            sent.append(time.monotonic())
        control.servoJ(q, 0.0, 0.0, PERIOD, 0.03, 2000.0)
        due += PERIOD
        time.sleep(max(due - time.monotonic(), 0.0))
    control.servoStop()
    control.disconnect()
    return sent[1:]


def connect(host: str, count: str) -> list[tuple[float, float]]:
    """Return the times that the receive and control interfaces take to connect [s]."""
    from rtde_control import RTDEControlInterface
    from rtde_receive import RTDEReceiveInterface

    def measure() -> tuple[float, float]:
        """Connect once, and return the times of both interfaces [s].

        The times do not include the end of an interface, which sleeps for 0.5 s.
        """
        start = time.monotonic()
        receive = RTDEReceiveInterface(host)
        middle = time.monotonic()
        control = RTDEControlInterface(host)
        end = time.monotonic()
        control.stopScript()
        control.disconnect()
        receive.disconnect()
        return middle - start, end - middle

    return [measure() for _ in range(int(count))]


def forever(host: str) -> None:
    """Receive like ur_rtde does until the process ends.

    A line is printed when receiving starts.
    """
    from rtde_receive import RTDEReceiveInterface

    receive = RTDEReceiveInterface(host)
    print("ready", flush=True)
    while receive.isConnected():
        time.sleep(1.0)


if __name__ == "__main__":
    address, role, *arguments = sys.argv[1:]
    roles = {
        "samples": samples,
        "servo": servo,
        "connect": connect,
        "forever": forever,
    }
    print(json.dumps(roles[role](address, *arguments)), flush=True)
