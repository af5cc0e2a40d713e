"""Child processes that end with this process, also if it is killed by SIGKILL.

Each child runs in a process group of its own below a supervisor (``supervisor.py``),
which ends the whole group when the connection to this process closes.  A program that
leaves its process group escapes.  On Windows, programs run without a supervisor, and
outlive a parent that is killed.
"""

from __future__ import annotations

import contextlib
import json
import os
import pickle
import select
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import IO, Final, NoReturn, TypeVar, final

from tool0.errors import Tool0Error
from tool0.installation import supervisor

R = TypeVar("R")

_POLL_PERIOD: Final = 0.1
"""Between two calls of ``while_running`` [wall s]."""
_CHUNK: Final = 1 << 20


class ChildProcessFailedError(Tool0Error):
    """Work in a child process was given up: a limit, a crash, or an unknown error."""


class ChildLimitExceededError(ChildProcessFailedError):
    """Work in a child process took too long, or too much memory."""


# --- programs ---


@final
class ChildProcess:
    """A program that ends with ``close``, and with this process however that ends."""

    def __init__(
        self,
        command: Sequence[str],
        *,
        environment: Mapping[str, str] | None = None,
        folder: Path | None = None,
        stdout: IO[bytes] | None = None,
        stderr: IO[bytes] | None = None,
        grace: float = 0.0,
    ) -> None:
        """Start it, with nothing on its standard input.

        A program that cannot be started exits with status 127.

        Args:
            command: The program and its arguments.
            environment: Its variables; those of this process if left out.
            folder: Where it runs; where this process does if left out.
            stdout: A file for its output; a temporary one if left out.
            stderr: A file for its errors; that of its output if left out.
            grace: Time between SIGINT and SIGKILL when it is ended [wall s]; 0 for
                SIGKILL at once.
        """
        self._log = tempfile.TemporaryFile()  # noqa: SIM115  # closed with the child
        self._is_closed = False
        self._pid: int | None = None
        output = self._log if stdout is None else stdout
        errors = output if stderr is None else stderr
        variables = dict(os.environ if environment is None else environment)
        if sys.platform == "win32":
            self._connection: socket.socket | None = None
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
                start_new_session=True,  # Ctrl-C is for this process alone
            )
        request = {
            "command": list(command),
            "environment": variables,
            "folder": None if folder is None else str(folder),
            "grace": grace,
        }
        with contextlib.suppress(OSError):  # it has ended; its status says so
            self._connection.sendall(json.dumps(request).encode() + b"\n")

    def __enter__(self) -> ChildProcess:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """End it."""
        self.close()

    @property
    def pid(self) -> int:
        """The process id of the program itself; 0 if it could not be started."""
        if self._connection is None:
            return self._process.pid
        if self._pid is None:
            with self._connection.makefile("rb") as stream:
                self._pid = int(stream.readline() or 0)
        return self._pid

    @property
    def exit_status(self) -> int | None:
        """Its exit status, negative for a signal; None while it runs."""
        return self._process.poll()

    def wait(self, timeout: float | None = None) -> int:
        """Wait for its end and return its exit status, negative for a signal.

        Raises:
            subprocess.TimeoutExpired: If it still runs after ``timeout`` [wall s].
        """
        return self._process.wait(timeout)

    def last_output(self, n_lines: int = 8) -> str:
        """Return the end of its output, if that had no file of its own."""
        self._log.seek(0)
        return last_lines(self._log.read().decode(errors="replace"), n_lines)

    def close(self) -> None:
        """End it and what it started, and wait for its end; twice is allowed."""
        if self._is_closed:
            return
        self._is_closed = True
        if self._connection is None:
            self._process.kill()
        else:
            self._connection.close()
        self._process.wait()
        self._log.close()


def run_program(
    command: Sequence[str],
    *,
    environment: Mapping[str, str] | None = None,
    folder: Path | None = None,
    timeout: float | None = None,
    while_running: Callable[[], None] | None = None,
) -> subprocess.CompletedProcess[str]:
    """Run a program to its end; the caller looks at its exit status.

    Args:
        command: The program and its arguments.
        environment: Its variables; if left out those of this process, with messages
            in English.
        folder: Where it runs; where this process does if left out.
        timeout: Time that it may take [wall s].
        while_running: Called about ten times a second until it has ended.

    Raises:
        subprocess.TimeoutExpired: If it takes longer.
    """
    if environment is None:
        environment = {**os.environ, "LC_ALL": "C"}
    with (
        tempfile.TemporaryFile() as out,
        tempfile.TemporaryFile() as errors,
        ChildProcess(
            command,
            environment=environment,
            folder=folder,
            stdout=out,
            stderr=errors,
            grace=1.0,
        ) as child,
    ):
        if while_running is not None:
            while child.exit_status is None:
                while_running()
                with contextlib.suppress(subprocess.TimeoutExpired):
                    child.wait(_POLL_PERIOD)
        status = child.wait(timeout)
        texts = []
        for file in (out, errors):
            file.seek(0)
            texts.append(file.read().decode(errors="replace"))
    return subprocess.CompletedProcess(command, status, *texts)


def _connection_pair() -> tuple[socket.socket, socket.socket]:
    """Return two connected sockets that block, whatever the default timeout is."""
    ours, theirs = socket.socketpair()
    ours.setblocking(True)  # rospy sets a default timeout, which makes them not block
    theirs.setblocking(True)
    return ours, theirs


def last_lines(text: str, n_lines: int = 6) -> str:
    """Return the last lines that are not empty, indented, to show in a message."""
    lines = [line for line in text.splitlines() if line.strip()]
    return "\n".join(f"  {line}" for line in lines[-n_lines:])


# --- work of this program ---


def call_in_child(work: Callable[[], R], *, timeout: float, memory: int) -> R:
    """Return what ``work`` returns, which must be picklable.

    Where there is no fork (Windows), it runs here, without limits.

    Args:
        work: Runs in a copy of this process.
        timeout: Time that it may take [wall s].
        memory: What it may allocate beyond what this process holds [bytes].

    Raises:
        ChildLimitExceededError: If it exceeds a limit.
        ChildProcessFailedError: If it crashes, or raises an error that cannot be
            pickled.
        Exception: What it raises itself.
    """
    if sys.platform == "win32":
        return work()
    connection, their_connection = _connection_pair()
    answer, their_answer = os.pipe()
    child = os.fork()
    if not child:
        connection.close()
        os.close(answer)
        _fork_worker(work, their_connection, their_answer, memory)
    their_connection.close()
    os.close(their_answer)
    try:
        packet = _receive(answer, timeout)
    finally:
        os.close(answer)
        connection.close()
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if not packet:
        how = signal.Signals(-status).name if status < 0 else f"exit status {status}"
        raise ChildProcessFailedError(f"it crashed ({how})")
    error, result = pickle.loads(packet)  # our own child wrote it
    if error is not None:
        raise error
    value: R = result
    return value


def _receive(answer: int, timeout: float) -> bytes:
    packet, deadline = bytearray(), time.monotonic() + timeout
    while True:
        left = deadline - time.monotonic()
        if left <= 0.0 or not select.select([answer], [], [], left)[0]:
            raise ChildLimitExceededError(f"it takes longer than {timeout:g} s")
        chunk = os.read(answer, _CHUNK)
        if not chunk:
            return bytes(packet)
        packet += chunk


def _fork_worker(
    work: Callable[[], object], connection: socket.socket, answer: int, memory: int
) -> NoReturn:
    """Become the supervisor of a process that does the work."""
    try:
        os.setsid()  # Ctrl-C is for the parent alone
        worker = os.fork()
        if not worker:
            os.setpgid(0, 0)
            _work(work, answer, memory)
        with contextlib.suppress(OSError):  # the worker may be first
            os.setpgid(worker, worker)
        os.close(answer)

        def wait() -> int:
            return os.waitstatus_to_exitcode(os.waitpid(worker, 0)[1])

        supervisor.supervise(worker, connection.fileno(), wait, grace=0.0)
    finally:
        os._exit(1)


def _work(work: Callable[[], object], answer: int, memory: int) -> NoReturn:
    """Do it, send the result, and exit."""
    packet = b""
    try:
        _limit_memory(memory)
        packet = pickle.dumps((None, work()))
    except MemoryError:
        limit = f"it takes more than {memory >> 20} MiB of memory"
        packet = pickle.dumps((ChildLimitExceededError(limit), None))
    except BaseException as error:  # the parent raises it
        packet = _pickled(error)
    finally:
        with contextlib.suppress(OSError), os.fdopen(answer, "wb") as stream:
            stream.write(packet)
        os._exit(0)


def _limit_memory(memory: int) -> None:
    import faulthandler
    import resource

    faulthandler.disable()  # the parent reports a crash
    with contextlib.suppress(OSError, ValueError):
        pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[0]
        limit = int(pages) * resource.getpagesize() + memory
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def _pickled(error: BaseException) -> bytes:
    error.__traceback__ = error.__cause__ = error.__context__ = None
    with contextlib.suppress(Exception):
        packet: bytes = pickle.dumps((error, None))
        pickle.loads(packet)  # some errors fail only here
        return packet
    text = f"it failed: {type(error).__name__}: {error}"
    return pickle.dumps((ChildProcessFailedError(text), None))
