"""The port between the schedule and the processes or machines that carry it out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, Protocol, final

from tool0.collect.worker import Chunk

QUEUED: Final = 2
"""Chunks that a worker has at a time: it works on one while the next one waits."""


@final
@dataclass(frozen=True, slots=True)
class Finished:
    """A chunk, and the message of the worker that had it."""

    chunk: Chunk
    message: bytes | None
    """None if the worker ended without one."""
    trouble: str = ""
    """Reason of the worker's end; empty if the chunk was not begun."""


def lost(chunks: Iterable[Chunk], trouble: str) -> list[Finished]:
    """Return the chunks of a worker that ended; it was at the first."""
    return [
        Finished(chunk, None, "" if number else trouble)
        for number, chunk in enumerate(chunks)
    ]


class Executor(Protocol):
    """Workers, each of which carries out its chunks one after the other."""

    @property
    def n_workers(self) -> int:
        """Number of workers."""

    @property
    def n_free(self) -> int:
        """Number of chunks that the workers would accept now."""

    def submit(self, chunk: Chunk) -> None:
        """Give a chunk to the worker with the least to do."""

    def finished(self, timeout: float) -> Sequence[Finished]:
        """Wait at most ``timeout`` [wall s]; return the chunks that came back.

        A worker that ended is replaced.

        Raises:
            CollectError: If workers do not start, or would give other episodes.
        """

    def close(self) -> None:
        """End all workers."""
