"""Child processes that end with this process, even if SIGKILL ends this process.

Each child runs in its own process group under a supervisor (``supervisor.py``).  The
supervisor ends the whole group when the connection to this process closes.  If the
supervisor is killed, ``wait`` and ``close`` end the group.  A program that leaves its
process group is not ended.  On Windows, programs run without a supervisor, and they
continue to run if their parent is killed.
"""

from __future__ import annotations

import contextlib
import json
import os
import pickle
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import IO, Final, NoReturn, TypeVar, final

from tool0.errors import Tool0Error
from tool0.installation import supervisor

R = TypeVar("R")
_Work = Callable[[], object]

_POLL_PERIOD: Final = 0.1
"""Interval between two calls of ``while_running`` [wall s]."""
_CHUNK: Final = 1 << 20


class ChildProcessFailedError(Tool0Error):
    """Raised if work in a child process exceeded a limit, crashed or failed."""


class ChildLimitExceededError(ChildProcessFailedError):
    """Raised if work in a child process took too long or used too much memory."""


# --- programs ---


@final
class ChildProcess(AbstractContextManager["ChildProcess"]):
    """A program that ends when it is closed, or when this process ends in any way."""

    def __init__(
        self,
        command: Sequence[str],
        *,
        environment: Mapping[str, str] | None = None,
        folder: Path | None = None,
        log: IO[bytes] | None = None,
        grace: float = 0.0,
    ) -> None:
        """Start the program with empty standard input.

        A program that cannot be started exits with status 127.

        Args:
            command: The program and its arguments.
            environment: Environment variables.  If omitted, the program inherits the
                variables of this process.
            folder: Working directory.  If omitted, the program runs in the working
                directory of this process.
            log: File for the program's output and errors.  If omitted, the output and
                errors are stored for ``completed`` and ``last_output``.
            grace: Time between SIGINT and SIGKILL when the program is stopped [wall s].
                If the time is 0, SIGKILL is sent immediately.
        """
        make = tempfile.TemporaryFile
        self._files = [] if log is not None else [make(), make()]
        self._is_closed = False
        self._pid: int | None = None
        self._reading = threading.Lock()
        output, errors = (log, log) if log is not None else self._files
        variables = dict(os.environ if environment is None else environment)
        self._connection: socket.socket | None = None
        if sys.platform == "win32":
            self._process = subprocess.Popen(
                command,
                env=variables,
                cwd=folder,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=errors,
            )
            return
        self._connection, theirs = _connection_pair()
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-I", "-S", supervisor.__file__],
                stdin=theirs.fileno(),
                stdout=output,
                stderr=errors,
                start_new_session=True,  # Ctrl-C must interrupt only this process
            )
        request = {
            "command": list(command),
            "environment": variables,
            "folder": None if folder is None else str(folder),
            "grace": grace,
        }
        # the program has already ended, and its status is read later
        with contextlib.suppress(OSError):
            self._connection.sendall(json.dumps(request).encode() + b"\n")

    def __exit__(self, *_: object) -> None:
        """End the program."""
        self.close()

    @property
    def pid(self) -> int:
        """Process ID of the program; 0 if it could not be started."""
        if self._connection is None:
            return self._process.pid
        with self._reading:
            if self._pid is None:
                with self._connection.makefile("rb") as stream:
                    self._pid = int([b"0", *stream.readline().split()][-1])
            return self._pid

    @property
    def exit_status(self) -> int | None:
        """Exit status of the program, negative for a signal; None while it runs."""
        return self._process.poll()

    def wait(self, timeout: float | None = None) -> int:
        """Wait for the program to end, and return its exit status.

        The status is negative if a signal ended the program.

        Raises:
            subprocess.TimeoutExpired: If the program still runs after ``timeout`` [wall
            s].
        """
        status = self._process.wait(timeout)
        self._end_orphans()
        return status

    def completed(
        self, timeout: float | None = None
    ) -> subprocess.CompletedProcess[str]:
        """Wait like ``wait``.  Return the program's exit status, output and errors."""
        status = self.wait(timeout)
        return subprocess.CompletedProcess(self._process.args, status, *self._texts())

    def last_output(self, n_lines: int = 8) -> str:
        """Return the last lines of output and errors.

        The text is empty if the output is written to a log.
        """
        return last_lines("\n".join(self._texts()), n_lines)

    def close(self) -> None:
        """End the program and its children, and wait.  A second call has no effect."""
        if self._is_closed:
            return
        self._is_closed = True
        if self._connection is None:
            self._process.kill()
        else:
            with contextlib.suppress(OSError):  # the supervisor was killed
                self._connection.shutdown(socket.SHUT_WR)
        self.wait()
        if self._connection is not None:
            with self._reading:
                self._connection.close()
        for file in self._files:
            file.close()

    def _end_orphans(self) -> None:
        """End the processes that are still running after the supervisor was killed."""
        if self._connection is None or self._process.returncode >= 0:
            return
        # the group has already ended, or it was never started
        with contextlib.suppress(OSError):
            if self.pid:
                os.killpg(self.pid, signal.SIGKILL)

    def _texts(self) -> Iterator[str]:
        for file in self._files:
            file.seek(0)
            yield file.read().decode(errors="replace")


def run_program(
    command: Sequence[str],
    *,
    environment: Mapping[str, str] | None = None,
    folder: Path | None = None,
    timeout: float | None = None,
    while_running: Callable[[], None] | None = None,
) -> subprocess.CompletedProcess[str]:
    """Run a program until it ends.  The caller checks the exit status.

    Without ``environment``, the program's messages are in English.  ``while_running``
    is called about ten times per second.

    Raises:
        subprocess.TimeoutExpired: If the program takes longer than ``timeout`` [wall
        s].
    """
    if environment is None:
        environment = {**os.environ, "LC_ALL": "C"}
    with ChildProcess(
        command, environment=environment, folder=folder, grace=1.0
    ) as child:
        while while_running is not None and child.exit_status is None:
            while_running()
            with contextlib.suppress(subprocess.TimeoutExpired):
                child.wait(_POLL_PERIOD)
        return child.completed(timeout)


def _connection_pair() -> tuple[socket.socket, socket.socket]:
    """Return two connected sockets that block, even if there is a default timeout."""
    ours, theirs = socket.socketpair()
    # rospy sets a default timeout, and sockets with a timeout do not block
    ours.setblocking(True)
    theirs.setblocking(True)
    return ours, theirs


def last_lines(text: str, n_lines: int = 6) -> str:
    """Return the last non-empty lines, indented for use in a message."""
    lines = [line for line in text.splitlines() if line.strip()]
    return "\n".join(f"  {line}" for line in lines[-n_lines:])


# --- work of this program ---


def call_in_child(work: Callable[[], R], *, timeout: float, memory: int) -> R:
    """Run ``work`` in a child process, and return the result of ``work``.

    The result must be picklable.

    Where fork is not available (Windows), ``work`` runs in this process without limits.

    Args:
        work: The function that runs in a copy of this process.
        timeout: Largest duration [wall s].
        memory: Largest amount of memory that ``work`` may allocate in addition to the
            memory of this process [bytes].

    Raises:
        ChildLimitExceededError: If ``work`` exceeds a limit.
        ChildProcessFailedError: If ``work`` crashes, or if it raises an error that
            cannot be pickled.
        Exception: If ``work`` raises an exception.  The same exception is raised.
    """
    if sys.platform == "win32":
        return work()
    connection, theirs = _connection_pair()
    child = os.fork()
    if not child:
        connection.close()
        _fork_worker(work, theirs, memory)
    theirs.close()
    try:
        packet = _receive(connection, timeout)
    finally:
        connection.close()
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if not packet:
        how = signal.Signals(-status).name if status < 0 else f"exit status {status}"
        raise ChildProcessFailedError(f"it crashed ({how})")
    # the packet is trusted, because our own child wrote it
    error, result = pickle.loads(packet)
    if error is not None:
        raise error
    value: R = result
    return value


def _receive(connection: socket.socket, timeout: float) -> bytes:
    packet, deadline = bytearray(), time.monotonic() + timeout
    with contextlib.suppress(TimeoutError):
        while (left := deadline - time.monotonic()) > 0.0:
            connection.settimeout(left)
            chunk = connection.recv(_CHUNK)
            if not chunk:
                return bytes(packet)
            packet += chunk
    raise ChildLimitExceededError(f"it takes longer than {timeout:g} s")


def _fork_worker(work: _Work, connection: socket.socket, memory: int) -> NoReturn:
    """Become the supervisor of a process that executes the work."""
    try:
        os.setsid()  # Ctrl-C must interrupt only the parent
        worker = os.fork()
        if not worker:
            os.setpgid(0, 0)
            _work(work, connection, memory)
        with contextlib.suppress(OSError):  # the worker may call setpgid first
            os.setpgid(worker, worker)

        def wait() -> int:
            return os.waitstatus_to_exitcode(os.waitpid(worker, 0)[1])

        supervisor.supervise(worker, connection.fileno(), wait, grace=0.0)
    finally:
        os._exit(1)


def _work(work: _Work, connection: socket.socket, memory: int) -> NoReturn:
    """Execute the work, send the result, and exit."""
    packet = b""
    try:
        _limit_memory(memory)
        packet = pickle.dumps((None, work()))
    except MemoryError:
        limit = f"it takes more than {memory >> 20} MiB of memory"
        packet = pickle.dumps((ChildLimitExceededError(limit), None))
    except BaseException as error:  # the parent raises the error again
        packet = _pickled(error)
    finally:
        with contextlib.suppress(OSError):
            connection.sendall(packet)
        os._exit(0)


def _limit_memory(memory: int) -> None:
    import faulthandler
    import resource

    faulthandler.disable()  # the parent reports crashes
    with contextlib.suppress(OSError, ValueError):
        pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[0]
        limit = int(pages) * resource.getpagesize() + memory
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def _pickled(error: BaseException) -> bytes:
    error.__traceback__ = error.__cause__ = error.__context__ = None
    with contextlib.suppress(Exception):
        packet: bytes = pickle.dumps((error, None))
        pickle.loads(packet)  # some errors can be pickled but not unpickled
        return packet
    text = f"it failed: {type(error).__name__}: {error}"
    return pickle.dumps((ChildProcessFailedError(text), None))
