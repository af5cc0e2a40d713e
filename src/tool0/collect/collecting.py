"""Scheduler that distributes the chunks of a collection and stores the episodes."""

from __future__ import annotations

import json
import logging
import math
import os
import time
from collections import Counter, deque
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, final, get_args

from tool0.collect.dataset import Dataset, Manifest, opened
from tool0.collect.executor import Executor, Finished
from tool0.collect.packets import unpacked
from tool0.collect.policy import Policy, located
from tool0.collect.settings import Format, Settings, require_extra
from tool0.collect.tasks import default_instruction, located_task
from tool0.collect.worker import Chunk
from tool0.errors import CollectError, ConfigError, did_you_mean

logger = logging.getLogger(__name__)

N_COPIES: Final = 8
_ROUNDS: Final = 2
"""Largest number of episodes per copy in a chunk."""
_WINDOW: Final = 4
"""Largest number of chunks per worker from the first missing chunk to the last
submitted one."""
_SHARES: Final = 8
"""Largest number of chunks per worker.  The number is smaller if each copy would
otherwise get less than one episode per chunk."""
_ATTEMPTS: Final = 3
"""The collection fails after this many workers have ended during the same chunk."""
_POLL: Final = 0.5
"""Interval between progress reports [wall s]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """Progress of a collection."""

    n_episodes: int
    n_requested: int
    n_succeeded: int
    rate: float
    """Episodes per second in this run [1 / wall s]."""


def collect(
    task: str,
    episodes: int,
    folder: str | Path,
    *,
    options: Mapping[str, Any] | None = None,
    workers: int | None = None,
    ray: str | None = None,
    policy: str | Policy | None = None,
    seed: int = 0,
    format: Format = "parquet",
    instruction: str | None = None,
    copies: int = N_COPIES,
    progress: Callable[[Progress], None] | None = None,
) -> Manifest:
    """Collect episodes of a task in a folder, or continue an earlier collection.

    Episode i depends only on the task, its options, the policy, ``seed`` and i.

    Args:
        task: Name of a built-in task, such as ``Lift``, or the id of a Gymnasium
            environment.  If a module or a file registers the environment, write
            ``module:id`` or ``file.py:id``.
        episodes: Number of episodes that the folder should contain.
        folder: A new or empty folder, or a folder that already contains some of these
            episodes.
        options: Keyword arguments of the environment, such as ``{"arm": "ur5e"}``.
        workers: Number of worker processes (default: one per processor).
        ray: Address of a Ray cluster, ``host:port``, or ``local`` for a Ray instance
            that ends with this call.  By default, the workers are processes on this
            machine, without Ray.
        policy: Callable that takes the seed of an episode and returns a function from
            observation to action.  The policy is a function or class at the top level
            of a module, or its name as ``module:name`` or ``file.py:name``.  By
            default, the task's expert is used.
        seed: Base from which the episodes' seeds are derived.
        format: Format of the data set: ``parquet`` or ``lerobot``.
        instruction: Description of the task for LeRobot's format; the default is the
            description in the task's definition.
        copies: Number of simulated copies that each worker steps.
        progress: Callback that is called about twice per second with the progress.

    Raises:
        ConfigError: If a parameter is wrong, or differs from the value that was used
            for the folder.
        CollectError: If a worker or the policy fails, or the disk is full.
        TransportError: If the Ray cluster cannot be reached.
    """
    require_extra()
    _check(episodes=episodes, copies=copies)
    if workers is not None:
        _check(workers=workers)
    if not 0 <= seed < 1 << 63:
        raise ConfigError(f"seed must be from 0 to 2**63 - 1, got {seed}")
    if format not in get_args(Format):
        hint = did_you_mean(format, get_args(Format))
        raise ConfigError(f"unknown format '{format}'{hint}")
    task, task_digest = located_task(task)
    said = instruction
    if said is None:
        said = default_instruction(task, task_digest)
    if instruction is not None and format != "lerobot":
        raise ConfigError("an instruction needs the format lerobot")
    name, digest = (None, None) if policy is None else located(policy)
    settings = Settings(
        task=task,
        task_digest=task_digest,
        options=_plain(options or {}),
        seed=seed,
        policy=name,
        digest=digest,
        format=format,
        instruction=said,
    )
    try:
        with opened(Path(folder), settings, episodes) as dataset:
            if not dataset.manifest.is_complete:
                with closing(_executor(workers, ray, settings, copies)) as executor:
                    _Schedule(executor, dataset, copies, progress).run()
            return dataset.manifest
    except OSError as error:
        where = error.filename or folder
        raise CollectError(
            f"{where}: {error.strerror or error}; the episodes so far are kept, and "
            "the same call continues"
        ) from error


def _check(**counts: int) -> None:
    for name, value in counts.items():
        if value < 1:
            raise ConfigError(f"{name} must be 1 or more, got {value}")


def _plain(options: Mapping[str, Any]) -> dict[str, Any]:
    try:
        plain: dict[str, Any] = json.loads(json.dumps(dict(options), allow_nan=False))
    except (TypeError, ValueError) as error:
        raise ConfigError(f"options of the environment: {error}") from None
    return plain


def _executor(
    workers: int | None, ray: str | None, settings: Settings, copies: int
) -> Executor:
    if ray is not None:
        from tool0.collect.ray_workers import RayWorkers

        return RayWorkers(ray, workers, settings, copies)
    from tool0.collect.local_workers import LocalWorkers

    return LocalWorkers(workers or len(os.sched_getaffinity(0)), settings, copies)


@final
class _Schedule:
    """Scheduler that gives chunks to workers and adds the results in order."""

    def __init__(
        self,
        executor: Executor,
        dataset: Dataset,
        n_copies: int,
        progress: Callable[[Progress], None] | None,
    ) -> None:
        self._executor = executor
        self._dataset = dataset
        self._progress = progress
        manifest = dataset.manifest
        self._n_before = manifest.n_episodes
        self._n_requested = manifest.n_requested
        n_left = self._n_requested - self._n_before
        share = n_left / executor.n_workers
        least = min(n_copies, math.ceil(share))
        self._size = min(max(least, math.ceil(share / _SHARES)), _ROUNDS * n_copies)
        self._window = _WINDOW * self._size * executor.n_workers
        starts = range(self._n_before, self._n_requested, self._size)
        self._waiting = deque(
            Chunk(first, min(first + self._size, self._n_requested)) for first in starts
        )
        self._messages: dict[int, bytes] = {}
        self._failures: Counter[Chunk] = Counter()

    def run(self) -> None:
        """Run until the data set is complete."""
        start = reported = time.monotonic()
        while not self._dataset.manifest.is_complete:
            self._give()
            finished = self._executor.finished(_POLL)
            for item in finished:
                if item.message is not None:
                    self._messages[item.chunk.first] = item.message
            lost = [item for item in finished if item.message is None]
            for item in reversed(lost):  # restores the original order
                self._return(item)
            self._add()
            now = time.monotonic()
            is_complete = self._dataset.manifest.is_complete
            if self._progress and (is_complete or now >= reported + _POLL):
                reported = now
                self._report(self._progress, now - start)

    def _give(self) -> None:
        """Submit chunks to free workers, within a window of episodes.

        The window starts at the first episode that is missing from the data set.
        """
        end = self._dataset.manifest.n_episodes + self._window
        while self._waiting and self._waiting[0].first < end and self._executor.n_free:
            self._executor.submit(self._waiting.popleft())

    def _return(self, item: Finished) -> None:
        self._waiting.appendleft(item.chunk)
        if not item.trouble:
            return
        logger.warning("a worker is replaced: %s", item.trouble)
        self._failures[item.chunk] += 1
        if self._failures[item.chunk] == _ATTEMPTS:
            raise CollectError(
                f"{_ATTEMPTS} workers ended in episodes {item.chunk.first} to "
                f"{item.chunk.end - 1}: {item.trouble}"
            )

    def _add(self) -> None:
        """Add all chunks that are next in order, in a single write operation."""
        index = self._dataset.manifest.n_episodes
        episodes: list[tuple[dict[str, Any], bytes]] = []
        problem = None
        while problem is None and index + len(episodes) in self._messages:
            header, files = unpacked(self._messages.pop(index + len(episodes)))
            problem = header.get("error")
            episodes += zip(header.get("episodes", ()), files, strict=True)
        if episodes:
            self._dataset.add(episodes)
        if problem is not None:
            raise CollectError(problem)

    def _report(self, progress: Callable[[Progress], None], elapsed: float) -> None:
        manifest = self._dataset.manifest
        progress(
            Progress(
                n_episodes=manifest.n_episodes,
                n_requested=manifest.n_requested,
                n_succeeded=manifest.n_succeeded,
                rate=(manifest.n_episodes - self._n_before) / elapsed,
            )
        )
