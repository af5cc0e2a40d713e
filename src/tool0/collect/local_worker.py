"""Program of a worker process, which answers requests on a Unix socket."""

from __future__ import annotations

import json
import socket
import sys
from typing import Final

from tool0.collect.packets import framed, packed, take_frame
from tool0.collect.worker import Worker

_RECEIVED: Final = 1 << 16


def main() -> None:
    """Answer requests on the socket in the first argument until it is closed."""
    path, number, values = sys.argv[1:]
    worker = Worker(**json.loads(values))
    with socket.socket(socket.AF_UNIX) as connection:
        connection.connect(path)
        connection.sendall(framed(packed({"worker": int(number)})))
        connection.sendall(framed(worker.hello()))
        buffer = bytearray()
        while received := connection.recv(_RECEIVED):
            buffer += received
            while (message := take_frame(buffer)) is not None:
                first, end = json.loads(message)
                connection.sendall(framed(worker.collect(first, end)))


if __name__ == "__main__":
    main()
