"""Interface between the schedule and the processes or machines that do the work."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, Protocol, final

from tool0.collect.worker import Chunk

QUEUED: Final = 2
"""Number of chunks that a worker holds: it works on one while the next one waits."""


@final
@dataclass(frozen=True, slots=True)
class Finished:
    """A chunk, and the message of the worker that it was given to."""

    chunk: Chunk
    message: bytes | None
    """Message of the worker; None if the worker ended without sending one."""
    trouble: str = ""
    """Reason for the worker's end; empty if it had not started the chunk."""


def lost(chunks: Iterable[Chunk], trouble: str) -> list[Finished]:
    """Return the chunks of a worker that ended while it worked on the first of them."""
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
        """Number of chunks that the workers would accept now."""

    def submit(self, chunk: Chunk) -> None:
        """Give a chunk to the worker with the fewest chunks."""

    def finished(self, timeout: float) -> Sequence[Finished]:
        """Wait at most ``timeout`` [wall s], and return the chunks that came back.

        A worker that ended is replaced.

        Raises:
            CollectError: If workers do not start, or would produce different episodes.
        """

    def close(self) -> None:
        """End all workers."""
