"""Compares tool0's Modbus server with pymodbus: start, latency, and flooding clients.

``python benchmarks/modbus.py`` prints the table of docs/adr/0019-modbus.md.  Each
server runs in a separate process, which has already loaded the modules that the UR
interface needs.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import pty
import select
import socket
import statistics
import struct
import subprocess
import sys
import tempfile
import time
import tty
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

HOST = "127.19.50.2"
PORT = 21502
STATUS = 2000
N = 3000
"""Number of requests in one measurement of the latency."""
FLOOD = 5.0
"""Duration of a flood [wall s]."""
TICKS = os.sysconf("SC_CLK_TCK")
READ_TCP = struct.pack(">HHHBBHH", 1, 0, 6, 9, 3, STATUS, 3)
READ_RTU = bytes.fromhex("0903 07d0 0003 040e")
"""Requests that read three registers, over TCP and over RTU.  The RTU request includes
its checksum."""


async def serve_ours(folder: Path) -> str:
    from tool0.devices.robotiq_registers import (
        Activation,
        CommandRegisters,
        Fault,
        ObjectStatus,
        StatusRegisters,
    )
    from tool0.ur.robotiq.modbus_rtu import ModbusRtu
    from tool0.ur.robotiq.modbus_tcp import ModbusTcp

    status = StatusRegisters(
        is_activated=True,
        goes_to=True,
        activation=Activation.COMPLETE,
        object_status=ObjectStatus.ARRIVED,
        fault=Fault.NONE,
        request=0,
        position=3,
        current=0,
    )
    gripper: Any = SimpleNamespace(
        status=status, command=CommandRegisters(), is_powered=True
    )
    await ModbusTcp(gripper).start(HOST, PORT - 502)
    rtu = ModbusRtu(gripper, folder / "gripper")
    rtu.open()
    return str(rtu.link)


async def serve_pymodbus(folder: Path) -> str:
    from pymodbus.server import ModbusSerialServer, ModbusTcpServer
    from pymodbus.simulator import DataType, SimData, SimDevice

    blocks = [SimData(start, 8, 0, DataType.REGISTERS) for start in (1000, STATUS)]
    device = SimDevice(0, blocks)
    tcp = ModbusTcpServer(device, address=(HOST, PORT))
    await tcp.serve_forever(background=True)
    port = (folder / "port").read_text(encoding="ascii")
    serial = ModbusSerialServer(device, port=port, baudrate=115200)
    await serial.serve_forever(background=True)
    return ""


SERVERS = {"ours": serve_ours, "pymodbus": serve_pymodbus}


def memory(pid: int | str = "self") -> float:
    """Return the resident memory of a process [MB]."""
    pages = int(Path(f"/proc/{pid}/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def processor_time(pid: int) -> float:
    """Return the processor time of a process [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").split()
    return (int(fields[13]) + int(fields[14])) / TICKS


async def serve(name: str, folder: Path) -> None:
    """Start a server, print the cost of its start, and serve."""
    import tool0.ur.rtde.server
    import tool0.ur.service  # noqa: F401

    before, start = memory(), time.process_time()
    path = await SERVERS[name](folder)
    took = time.process_time() - start
    report = {"start": took, "memory": memory() - before, "path": path}
    print(json.dumps(report), flush=True)
    await asyncio.Event().wait()


def latency(ask: Callable[[], object]) -> str:
    """Return the median time until a reply [µs]."""
    found = []
    for _ in range(N):
        start = time.perf_counter()
        ask()
        found.append(1e6 * (time.perf_counter() - start))
    return f"{statistics.median(found):.0f}"


def ask_tcp(client: socket.socket) -> bytes:
    """Return the reply to a request over TCP."""
    client.sendall(READ_TCP)
    reply = b""
    while len(reply) < 15:
        reply += client.recv(64)
    return reply


def ask_serial(terminal: int) -> bytes:
    """Return the reply to a request over RTU.

    If the reply is not complete after half a second, its first part is returned.
    """
    os.write(terminal, READ_RTU)
    reply = b""
    while len(reply) < 11 and select.select([terminal], [], [], 0.5)[0]:
        reply += os.read(terminal, 64)
    return reply


def count_pipelined(client: socket.socket) -> int:
    """Return how many of ten requests in one packet are answered."""
    client.sendall(10 * READ_TCP)
    time.sleep(0.5)
    return len(client.recv(4096)) // 15


def flood(pid: int) -> dict[str, str]:
    """Return the effects of a client that sends requests but reads no replies."""
    with socket.create_connection((HOST, PORT), timeout=5.0) as other:
        before, start = memory(pid), processor_time(pid)
        with socket.create_connection((HOST, PORT)) as client:
            client.setblocking(False)
            end, waits = time.monotonic() + FLOOD, [0.0]
            while time.monotonic() < end:
                with contextlib.suppress(BlockingIOError):
                    for _ in range(100):
                        client.send(20 * READ_TCP)
                asked = time.monotonic()
                ask_tcp(other)
                waits.append(1e3 * (time.monotonic() - asked))
                time.sleep(0.01)
            used = (processor_time(pid) - start) / FLOOD
            grown = memory(pid) - before
    return {
        "flood: processor": f"{used:.0%}",
        "flood: memory [MB]": f"{grown:.1f}",
        "flood: longest reply to another client [ms]": f"{max(waits):.1f}",
    }


def measure(name: str) -> dict[str, str]:
    """Return the table row of a server."""
    with tempfile.TemporaryDirectory() as folder:
        ours, theirs = pty.openpty()
        tty.setraw(theirs)
        (Path(folder) / "port").write_text(os.ttyname(theirs), encoding="ascii")
        with subprocess.Popen(
            [sys.executable, __file__, name, folder], stdout=subprocess.PIPE, text=True
        ) as server:
            try:
                assert server.stdout is not None
                report = json.loads(server.stdout.readline())
                path = report["path"]
                terminal = os.open(path, os.O_RDWR | os.O_NOCTTY) if path else ours
                with socket.create_connection((HOST, PORT), timeout=5.0) as client:
                    client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                    row = {
                        "start: processor time [ms]": f"{1e3 * report['start']:.0f}",
                        "memory [MB]": f"{report['memory']:.1f}",
                        "TCP reply [µs]": latency(lambda: ask_tcp(client)),
                        "RTU reply [µs]": latency(lambda: ask_serial(terminal)),
                        "answers to 10 requests": str(count_pipelined(client)),
                    }
                    row |= flood(server.pid)
            finally:
                server.kill()
        return row


def main() -> None:
    """Print the results of both servers side by side."""
    if len(sys.argv) == 3:
        asyncio.run(serve(sys.argv[1], Path(sys.argv[2])))
        return
    rows = {name: measure(name) for name in SERVERS}
    print(f"| | {' | '.join(rows)} |")
    for key in next(iter(rows.values())):
        print(f"| {key} | {' | '.join(row[key] for row in rows.values())} |")


if __name__ == "__main__":
    main()
