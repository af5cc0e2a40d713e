"""A worker, which simulates the episodes of a chunk and returns them as a message."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

from tool0.collect.encoding import encoded
from tool0.collect.packets import packed
from tool0.collect.policy import loaded
from tool0.collect.rollout import Rollout
from tool0.collect.settings import Settings, episode_seed, programs
from tool0.errors import Tool0Error


@final
@dataclass(frozen=True, slots=True)
class Chunk:
    """A range of consecutive episodes, which is the unit of work."""

    first: int
    end: int
    """Index after the last episode."""

    def __len__(self) -> int:
        """Return the number of episodes."""
        return self.end - self.first


def arguments(settings: Settings, n_copies: int) -> dict[str, Any]:
    """Return the arguments of a ``Worker`` as JSON values."""
    paths = [str(Path(path).absolute()) for path in sys.path]
    return {"settings": settings.to_json(), "n_copies": n_copies, "paths": paths}


@final
class Worker:
    """Collects chunks of episodes with the same environments."""

    def __init__(
        self, settings: Mapping[str, Any], n_copies: int, paths: Sequence[str]
    ) -> None:
        """Store the settings.

        The driver compares the programs before any episode is run.

        Args:
            settings: Values that ``Settings.to_json`` returned.
            n_copies: Number of simulated copies that are stepped.
            paths: Folders in which the driver finds modules.
        """
        sys.path += [path for path in paths if path not in sys.path]
        self._settings = Settings.from_json(settings)
        self._n_copies = n_copies
        self._rollout: Rollout | None = None

    def hello(self) -> bytes:
        """Return a message with the values of ``programs`` on this machine."""
        return packed({"programs": programs()})

    def collect(self, first: int, end: int) -> bytes:
        """Return a message with the episodes in order, or with an error."""
        try:
            rows, files = self._episodes(Chunk(first, end))
        except Tool0Error as error:
            return packed({"error": str(error)})
        except Exception as error:  # raised by the policy or by a bug
            frames = traceback.extract_tb(error.__traceback__)
            where = f"{frames[-1].filename}:{frames[-1].lineno}"
            return packed({"error": f"{where}: {type(error).__name__}: {error}"})
        return packed({"episodes": rows}, files)

    def _episodes(self, chunk: Chunk) -> tuple[list[dict[str, Any]], list[bytes]]:
        settings = self._settings
        if self._rollout is None:
            policy = None
            if settings.policy is not None:
                policy = loaded(settings.policy, settings.digest)
            self._rollout = Rollout(
                *(settings.task, settings.options, policy, self._n_copies),
                digest=settings.task_digest,
            )
        index_of = {
            episode_seed(settings.seed, index): index
            for index in range(chunk.first, chunk.end)
        }
        found = {}
        for episode in self._rollout.episodes(index_of):
            index = index_of[episode.seed]
            found[index] = encoded(episode, index, settings.format)
        rows, files = zip(*(found[index] for index in sorted(found)), strict=True)
        return list(rows), list(files)
