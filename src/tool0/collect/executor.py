"""Interface between the schedule and the processes or machines that do the work."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, Protocol, final

from tool0.collect.worker import Chunk

QUEUED: Final = 2
"""Largest number of chunks that a worker has: the current one and the next one."""


@final
@dataclass(frozen=True, slots=True)
class Finished:
    """A chunk, and the message from the worker that processed the chunk."""

    chunk: Chunk
    message: bytes | None
    """Message of the worker; None if it ended without a message."""
    trouble: str = ""
    """Reason why the worker ended; empty if it had not started the chunk."""


def lost(chunks: Iterable[Chunk], trouble: str) -> list[Finished]:
    """Return the chunks of a worker that ended while processing the first one."""
    return [
        Finished(chunk, None, "" if number else trouble)
        for number, chunk in enumerate(chunks)
    ]


class Executor(Protocol):
    """Workers, each of which processes its chunks one after the other."""

    @property
    def n_workers(self) -> int:
        """Number of workers."""

    @property
    def n_free(self) -> int:
        """Number of additional chunks that the workers accept now."""

    def submit(self, chunk: Chunk) -> None:
        """Give a chunk to the worker with the fewest chunks."""

    def finished(self, timeout: float) -> Sequence[Finished]:
        """Wait for up to ``timeout`` [wall s], and return the finished and lost chunks.

        A worker that has ended is replaced.

        Raises:
            CollectError: If workers do not start, or would produce different episodes
                because their programs differ.
        """

    def close(self) -> None:
        """End all workers."""
