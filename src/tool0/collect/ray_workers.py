"""Workers that are Ray actors on one or several machines.

Only bytes, numbers and strings are sent, but Ray serializes them with pickle.  Anyone
who can connect to a cluster can therefore execute code on it, so its network must be
trusted.
"""

from __future__ import annotations

import contextlib
import importlib.util
import os
import secrets
import signal
import socket
import sys
import tempfile
import threading
import time
from collections import deque
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final, final

from tool0.collect.executor import QUEUED, Finished, lost
from tool0.collect.packets import unpacked
from tool0.collect.settings import Settings, differences, programs
from tool0.collect.worker import Chunk, Worker, arguments
from tool0.errors import CollectError, ConfigError, TransportError
from tool0.installation.child_process import ChildProcess, last_lines, run_program

LOCAL: Final = "local"
_CONNECT_TIMEOUT: Final = 5.0
"""Longest wait for a connection to the cluster [wall s]."""
_ANSWER_TIMEOUT: Final = 30.0
"""Longest wait for the cluster's answer [wall s].  The cluster must start a Python
process before it can answer."""
_START_TIMEOUT: Final = 120.0
"""Longest start-up time of a local Ray instance, and longest time without a ready
worker [wall s].  On a busy machine, Ray's twelve processes start slowly."""
_POLL_PERIOD: Final = 0.05
"""Interval between checks of a Ray instance that is starting [wall s]."""
_LOOPBACK: Final = "RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"
"""Environment variable that Ray reads when it is imported; if its value is 0, Ray uses
only 127.0.0.1."""


@final
class _Actor:
    """A worker, with its chunks and the message that describes its programs."""

    def __init__(self, handle: Any) -> None:
        self.handle = handle
        self.hello = handle.hello.remote()
        self.is_ready = False
        self.chunks: deque[tuple[Any, Chunk]] = deque()


@final
class RayWorkers:
    """Ray actors, each with one processor, which end when this process ends."""

    def __init__(
        self, address: str, n_workers: int | None, settings: Settings, n_copies: int
    ) -> None:
        """Connect to Ray at ``address``; ``local`` starts Ray on this machine.

        Raises:
            ConfigError: If Ray is not installed, or ``address`` is not an address.
            TransportError: If no cluster answers at the address.
        """
        self._exits = contextlib.ExitStack()
        with contextlib.ExitStack() as exits:
            self._ray = exits.enter_context(_connected(address, n_workers))
            self._exits = exits.pop_all()
        n_processors = int(self._ray.cluster_resources().get("CPU", 0))
        n_workers = n_workers or max(n_processors, 1)
        self._make = self._ray.remote(num_cpus=1)(Worker)
        self._arguments = arguments(settings, n_copies)
        self._actors = [self._started() for _ in range(n_workers)]
        self._waited = 0.0

    @property
    def n_workers(self) -> int:
        """Number of workers."""
        return len(self._actors)

    @property
    def n_free(self) -> int:
        """Number of additional chunks that the workers accept now."""
        return sum(QUEUED - len(actor.chunks) for actor in self._ready())

    def submit(self, chunk: Chunk) -> None:
        """Give a chunk to the worker with the fewest chunks."""
        actor = min(self._ready(), key=lambda item: len(item.chunks))
        reference = actor.handle.collect.remote(chunk.first, chunk.end)
        actor.chunks.append((reference, chunk))

    def finished(self, timeout: float) -> Sequence[Finished]:
        """Wait for finished chunks; see ``Executor.finished``."""
        waiting = {
            actor.chunks[0][0] if actor.is_ready else actor.hello: actor
            for actor in self._actors
            if actor.chunks or not actor.is_ready
        }
        done, _ = self._ray.wait(list(waiting), num_returns=len(waiting), timeout=0.0)
        if not done:
            done, _ = self._ray.wait(list(waiting), num_returns=1, timeout=timeout)
            self._check_start(timeout if not done else 0.0)
        found: list[Finished] = []
        for reference in done:
            found += self._taken(waiting[reference], reference)
        return found

    def close(self) -> None:
        """End all workers, and close the connection."""
        for actor in self._actors:
            self._ray.kill(actor.handle)
        self._exits.close()

    def _ready(self) -> list[_Actor]:
        return [actor for actor in self._actors if actor.is_ready]

    def _started(self) -> _Actor:
        return _Actor(self._make.remote(**self._arguments))

    def _taken(self, actor: _Actor, reference: Any) -> list[Finished]:
        try:
            message: bytes = self._ray.get(reference)
        except self._ray.exceptions.RayError as error:
            return self._replaced(actor, str(error))
        if actor.is_ready:
            _, chunk = actor.chunks.popleft()
            return [Finished(chunk, message)]
        if different := differences(programs(), unpacked(message)[0]["programs"]):
            raise CollectError(
                f"a machine of the cluster has {', '.join(different)}, and its "
                "episodes would not be the same"
            )
        actor.is_ready = True
        return []

    def _replaced(self, actor: _Actor, trouble: str) -> list[Finished]:
        """Start another worker in place of a worker that has ended."""
        trouble = last_lines(trouble)
        if not actor.is_ready:
            raise CollectError(
                "a worker did not start; every machine of the cluster needs "
                f"pip install '.[ray]':\n{trouble}"
            )
        self._actors[self._actors.index(actor)] = self._started()
        return lost([chunk for _, chunk in actor.chunks], trouble)

    def _check_start(self, waited: float) -> None:
        """Raise CollectError if there has been no worker for a long time."""
        self._waited = 0.0 if self._ready() else self._waited + waited
        if self._waited > _START_TIMEOUT:
            free = self._ray.available_resources().get("CPU", 0.0)
            raise CollectError(
                f"no worker has started within {_START_TIMEOUT:.0f} s: the cluster has "
                f"{free:g} free processors"
            )


# ---- connections ---------------------------------------------------------------------


@contextlib.contextmanager
def _connected(address: str, n_workers: int | None) -> Iterator[Any]:
    """Connect to a cluster or start a cluster, and yield the module ``ray``."""
    with contextlib.ExitStack() as exits:
        if address == LOCAL:
            n_processors = n_workers or len(os.sched_getaffinity(0))
            address = exits.enter_context(own_cluster(n_processors))
        else:
            _reach(address)
        ray = _imported()
        if ray.is_initialized():
            raise ConfigError(
                "this process has a connection to Ray: end it with ray.shutdown()"
            )
        exits.enter_context(_signals_kept())
        exits.callback(ray.shutdown)
        try:
            ray.init(
                address=address,
                log_to_driver=False,
                configure_logging=False,
                logging_level="error",
            )
        except (Exception, SystemExit) as error:  # Ray raises many types of errors
            raise TransportError(f"Ray at {address}: {error}") from error
        yield ray


@contextlib.contextmanager
def own_cluster(n_processors: int) -> Iterator[str]:
    """Start a Ray instance that is reachable only from this machine.

    The instance ends when this process ends: Ray's processes form a process group,
    which a supervisor ends.  Other users cannot connect to the instance because they do
    not have its token.

    Raises:
        ConfigError: If Ray has already been imported with support for clusters of
            several machines.
        TransportError: If Ray does not start.
    """
    if sys.modules.get("ray") is not None and os.environ.get(_LOOPBACK) != "0":
        raise ConfigError(
            "Ray was imported before: set the environment variable "
            f"{_LOOPBACK}=0 before that, or start this Ray first"
        )
    os.environ.update({_LOOPBACK: "0", "RAY_AUTH_MODE": "token"})
    os.environ["RAY_AUTH_TOKEN"] = _token()
    _imported()
    with tempfile.TemporaryDirectory(
        prefix="tool0-ray-", ignore_cleanup_errors=True
    ) as folder:
        answer = Path(folder, "address")
        program = [sys.executable, "-m", "tool0.collect.ray_head", folder]
        with ChildProcess([*program, str(n_processors)]) as head:
            deadline = time.monotonic() + _START_TIMEOUT
            while not answer.exists():
                if head.exit_status is not None:
                    raise TransportError(f"Ray does not start:\n{head.last_output()}")
                if time.monotonic() > deadline:
                    raise TransportError(
                        f"Ray has not started within {_START_TIMEOUT:.0f} s, which is "
                        "long even for a busy machine; try again when less runs, or "
                        f"leave out --ray\n{head.last_output()}".rstrip()
                    )
                time.sleep(_POLL_PERIOD)
            yield answer.read_text()


@cache
def _token() -> str:
    """Return a token that excludes other users; Ray reads the token only once."""
    return secrets.token_hex(32)


def _imported() -> Any:
    _require_ray()
    import ray

    return ray


def _require_ray() -> None:
    """Raise ConfigError if Ray is not installed, without importing Ray.

    A process that has already imported Ray can no longer start ``own_cluster``.
    """
    if importlib.util.find_spec("ray") is None:
        raise ConfigError("Ray is not installed; run pip install '.[ray]'")


def _reach(address: str) -> None:
    """Raise an error if no cluster answers; Ray would retry for minutes."""
    host, colon, port = address.rpartition(":")
    if not (host and colon and port.isdecimal()) or "/" in address:
        raise ConfigError(
            f"'{address}' is no address of a Ray cluster; write HOST:PORT, such as "
            "10.0.0.1:6379, or local"
        )
    _require_ray()
    try:
        socket.create_connection(
            (host.strip("[]"), int(port)), _CONNECT_TIMEOUT
        ).close()
    except (OSError, OverflowError) as error:
        raise TransportError(f"no Ray cluster at {address}: {error}") from None
    import subprocess

    command = [sys.executable, "-m", "ray.scripts.scripts", "health-check"]
    try:
        done = run_program([*command, "--address", address], timeout=_ANSWER_TIMEOUT)
    except subprocess.TimeoutExpired:
        raise TransportError(
            f"what listens at {address} does not answer as a Ray cluster does; if it "
            "is one, see that RAY_AUTH_TOKEN is its token"
        ) from None
    if done.returncode:
        said = last_lines(done.stderr)
        raise TransportError(f"the Ray cluster at {address} refuses:\n{said}")


@contextlib.contextmanager
def _signals_kept() -> Iterator[None]:
    """Restore the SIGTERM handler, which Ray replaces."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.getsignal(signal.SIGTERM)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
