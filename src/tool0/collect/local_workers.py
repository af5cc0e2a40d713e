"""Workers that are single-threaded processes on this machine."""

from __future__ import annotations

import contextlib
import json
import os
import selectors
import socket
import sys
import tempfile
from collections import deque
from collections.abc import Sequence
from pathlib import Path
from typing import Final, final

from tool0.collect.executor import QUEUED, Finished, lost
from tool0.collect.packets import framed, take_frame, unpacked
from tool0.collect.settings import Settings, differences, programs
from tool0.collect.worker import Chunk, arguments
from tool0.errors import CollectError
from tool0.installation.child_process import ChildProcess

_RECEIVED: Final = 1 << 20
_ONE_THREAD: Final = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"
)


@final
class _Process:
    """A worker's process, with its chunks and, once established, its connection."""

    def __init__(self, child: ChildProcess) -> None:
        self.child = child
        self.connection: socket.socket | None = None
        self.buffer = bytearray()
        self.is_ready = False
        self.chunks: deque[Chunk] = deque()

    def close(self) -> None:
        if self.connection is not None:
            self.connection.close()
        self.child.close()


@final
class LocalWorkers:
    """Worker processes, which always end when this process ends."""

    def __init__(self, n_workers: int, settings: Settings, n_copies: int) -> None:
        """Start the processes without waiting for them."""
        self._arguments = json.dumps(arguments(settings, n_copies))
        self._folder = tempfile.TemporaryDirectory(prefix="tool0-")
        self._path = str(Path(self._folder.name, "workers"))
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(self._path)  # only this user can open the folder
        self._listener.listen()
        self._listener.setblocking(False)
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._listener, selectors.EVENT_READ)
        self._processes = [self._started(number) for number in range(n_workers)]

    @property
    def n_workers(self) -> int:
        """Number of workers."""
        return len(self._processes)

    @property
    def n_free(self) -> int:
        """Number of additional chunks that the workers accept now."""
        ready = [process for process in self._processes if process.is_ready]
        return sum(QUEUED - len(process.chunks) for process in ready)

    def submit(self, chunk: Chunk) -> None:
        """Give a chunk to the worker with the fewest chunks."""
        ready = [process for process in self._processes if process.is_ready]
        process = min(ready, key=lambda item: len(item.chunks))
        process.chunks.append(chunk)
        assert process.connection is not None
        message = framed(json.dumps([chunk.first, chunk.end]).encode())
        with contextlib.suppress(OSError):  # `finished` detects the end of a process
            process.connection.sendall(message)

    def finished(self, timeout: float) -> Sequence[Finished]:
        """Wait for finished chunks; see ``Executor.finished``."""
        found: list[Finished] = []
        for key, _ in self._selector.select(timeout):
            if key.fileobj is self._listener:
                self._accept()
            else:
                found += self._received(key.data)
        for process in self._processes:
            if process.connection is None and process.child.exit_status is not None:
                raise CollectError(f"a worker did not start: {_end_of(process.child)}")
        return found

    def close(self) -> None:
        """End all workers."""
        for process in self._processes:
            process.close()
        self._selector.close()
        self._listener.close()
        self._folder.cleanup()

    def _started(self, number: int) -> _Process:
        command = [sys.executable, "-m", "tool0.collect.local_worker", self._path]
        return _Process(
            ChildProcess(
                [*command, str(number), self._arguments],
                environment=os.environ | _ONE_THREAD,
            )
        )

    def _accept(self) -> None:
        """Accept the connection of a worker and read its identification."""
        connection, _ = self._listener.accept()
        connection.setblocking(True)
        with connection.makefile("rb", buffering=0) as stream:
            buffer = bytearray()
            while (message := take_frame(buffer)) is None:
                if not (byte := stream.read(1)):
                    return  # the worker has ended
                buffer += byte
        process = self._processes[unpacked(message)[0]["worker"]]
        process.connection = connection
        self._selector.register(connection, selectors.EVENT_READ, process)

    def _received(self, process: _Process) -> list[Finished]:
        assert process.connection is not None
        try:
            received = process.connection.recv(_RECEIVED)
        except OSError:
            received = b""
        if not received:
            return self._replaced(process)
        process.buffer += received
        found = []
        while (message := take_frame(process.buffer)) is not None:
            if process.is_ready:
                found.append(Finished(process.chunks.popleft(), message))
                continue
            theirs = unpacked(message)[0]["programs"]
            if different := differences(programs(), theirs):
                raise CollectError(f"a worker has {', '.join(different)}")
            process.is_ready = True
        return found

    def _replaced(self, process: _Process) -> list[Finished]:
        """Start another process in place of a process that has ended."""
        assert process.connection is not None
        self._selector.unregister(process.connection)
        process.child.wait()
        trouble = _end_of(process.child)
        if not process.is_ready:
            raise CollectError(f"a worker did not start: {trouble}")
        process.close()
        number = self._processes.index(process)
        self._processes[number] = self._started(number)
        return lost(process.chunks, trouble)


def _end_of(child: ChildProcess) -> str:
    status = child.exit_status
    how = (
        f"signal {-status}" if status is not None and status < 0 else f"status {status}"
    )
    said = child.last_output()
    return f"it ended with {how}" + (f":\n{said}" if said else "")
