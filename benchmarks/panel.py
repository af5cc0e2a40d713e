"""Measures the cost of pages for the control loop, such as late ticks.

The pages are WebSocket clients in a separate process, like browsers.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final
from urllib.parse import urlsplit

from websockets.asyncio.client import connect

import tool0
from tool0.panel.server import Panel, load

DURATION: Final = 3.0
"""Duration of one round with one load [wall s]."""
ROUNDS: Final = 3
_WARM_UP: Final = 1.0
"""Time until the pages are connected [wall s]."""
_SUBSCRIBE: Final = json.dumps({"id": 1, "method": "subscribe_view"})
_STEER: Final = json.dumps(
    {
        "method": "steer_joints",
        "params": {
            "controller": "eff_joint_traj_controller",
            "positions": {"wrist_3_joint": 0.1},
        },
    }
)


@dataclass(frozen=True)
class Load:
    """Numbers of pages in one measurement, by their behavior."""

    reading: int = 0
    stuck: int = 0
    """Number of pages that connect and never read."""
    flooding: int = 0
    """Number of pages that send as fast as possible."""


ALONE: Final = "0 pages"
FEW: Final = "5 pages"
LOADS: Final = {
    ALONE: Load(),
    FEW: Load(reading=5),
    "20 pages": Load(reading=20),
    "1 page and 1 that never reads": Load(reading=1, stuck=1),
    "1 page and 1 that floods": Load(reading=1, flooding=1),
}


@dataclass(frozen=True)
class Cost:
    """Cost of one load."""

    overruns: float
    """Number of ticks that began more than one control period late, per 10 s."""
    cpu: float
    """Processor time of the simulation process, per wall second."""
    bytes_per_second: float
    """Bytes per second that are sent to each page that reads."""


def costs() -> dict[str, Cost]:
    """Measure the cost of every load with one running robot.

    The loads alternate.  For each load, the round with the fewest late ticks is used,
    because other programs on the machine can only add late ticks.
    """
    logging.getLogger("tool0.simulation.loop").setLevel(logging.ERROR)
    rounds: dict[str, list[Cost]] = {name: [] for name in LOADS}
    load()
    with tool0.bringup() as robot, Panel(robot) as panel:
        for _ in range(ROUNDS):
            for name, pages in LOADS.items():
                rounds[name].append(_cost(robot, panel.url, pages))
    return {
        name: min(found, key=lambda cost: cost.overruns)
        for name, found in rounds.items()
    }


def _cost(robot: tool0.Robot, url: str, load: Load) -> Cost:
    with _pages(url, load) as pages:
        time.sleep(_WARM_UP)
        wall, cpu = time.perf_counter(), time.process_time()
        overruns, start = robot.snapshot.overruns, robot.time
        time.sleep(DURATION)
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        ticks = (robot.time - start) / robot.control_period
        late = (robot.snapshot.overruns - overruns) / ticks
        received = json.loads(pages.communicate(timeout=60.0)[0])
    return Cost(
        overruns=late * 10.0 / robot.control_period,
        cpu=cpu / wall,
        bytes_per_second=received / max(1, load.reading),
    )


@contextlib.contextmanager
def _pages(url: str, load: Load) -> Iterator[subprocess.Popen[bytes]]:
    words = [load.reading, load.stuck, load.flooding]
    command = [sys.executable, __file__, url, *map(str, words)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as pages:
        yield pages


# ---- the process of the pages --------------------------------------------------------


async def _run_pages(url: str, load: Load) -> float:
    """Run the pages, and return the bytes per second that the readers received."""
    tasks = [asyncio.create_task(_flood(url)) for _ in range(load.flooding)]
    stuck = [_open_unread(url) for _ in range(load.stuck)]
    duration = _WARM_UP + DURATION
    readers = [_read(url, duration) for _ in range(load.reading)]
    received = await asyncio.gather(asyncio.sleep(duration, 0.0), *readers)
    for task in tasks:
        task.cancel()
    for connection in stuck:
        connection.close()
    return sum(received) / duration


def _socket_url(url: str) -> str:
    return f"ws://{urlsplit(url).netloc}/ws?{urlsplit(url).query}"


async def _read(url: str, duration: float) -> float:
    end = time.monotonic() + duration
    n_bytes = 0
    async with connect(_socket_url(url), compression=None) as page:
        await page.send(_SUBSCRIBE)
        while (left := end - time.monotonic()) > 0.0:
            with contextlib.suppress(TimeoutError, asyncio.TimeoutError):
                n_bytes += len(await asyncio.wait_for(page.recv(), left))
    return float(n_bytes)


async def _flood(url: str) -> None:
    async with connect(_socket_url(url), compression=None) as page:

        async def read() -> None:
            async for _ in page:
                pass

        reading = asyncio.create_task(read())
        await page.send(_SUBSCRIBE)
        try:
            while True:
                await page.send(_STEER)
        finally:
            reading.cancel()


def _open_unread(url: str) -> socket.socket:
    parts = urlsplit(url)
    connection = socket.create_connection((parts.hostname, parts.port))
    connection.sendall(
        f"GET /ws?{parts.query} HTTP/1.1\r\nHost: {parts.netloc}\r\n"
        "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n".encode()
    )
    while b"\r\n\r\n" not in connection.recv(4096):
        pass
    # A WebSocket text frame of a client, with a mask of zeros.
    header = bytes((0x81, 0x80 | len(_SUBSCRIBE), 0, 0, 0, 0))
    connection.sendall(header + _SUBSCRIBE.encode())
    return connection


if __name__ == "__main__":
    address, *numbers = sys.argv[1:]
    print(json.dumps(asyncio.run(_run_pages(address, Load(*map(int, numbers))))))
