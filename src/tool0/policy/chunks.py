"""Schedule of chunks of actions: when to request the next chunk, and the next action.

For each observation, a policy returns the actions of the next steps.  If the actions
are received some steps after the observation, the actions for the steps that have
passed are skipped.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from tool0.errors import ConfigError

Array = NDArray[np.float64]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ChunkOptions:
    """Options for executing chunks of actions."""

    execute: int | None = None
    """Number of actions of a chunk that are executed before the next chunk replaces it;
    by default, all actions are executed."""
    ensemble: float | None = None
    """Decay rate of a temporal ensemble.  The policy is queried in each step, and the
    weighted mean of all its predictions for the step is executed.  The i-th oldest
    prediction has the weight exp(-ensemble · i), as in ACT (Zhao et al. 2023)."""
    compensate: bool = True
    """Whether to skip the actions for steps that have passed when a chunk is
    received."""

    def __post_init__(self) -> None:
        """Check the values.

        Raises:
            ConfigError: If a value is out of range, or both ``execute`` and
                ``ensemble`` are given.
        """
        if self.execute is not None and self.execute < 1:
            raise ConfigError(f"execute must be 1 or more actions, got {self.execute}")
        if self.ensemble is not None:
            if not (math.isfinite(self.ensemble) and self.ensemble >= 0.0):
                raise ConfigError(f"ensemble must be 0 or more, got {self.ensemble}")
            if self.execute is not None:
                raise ConfigError("an ensemble asks in each step: leave out execute")


class _Chunk(NamedTuple):
    first: int
    """Step of the chunk's first action."""
    actions: Array
    """Actions of the chunk, shape (h, m)."""

    @property
    def end(self) -> int:
        return self.first + len(self.actions)


@final
class Chunks:
    """The chunks of one episode, with actions that are indexed by step."""

    def __init__(self, options: ChunkOptions) -> None:
        self._options = options
        self._chunks: list[_Chunk] = []
        self._asked: int | None = None
        self._next = 0
        """First step for which the next chunk is needed."""
        self._delay = 0
        """Number of steps between the last request and its answer."""

    def wants(self, step: int) -> bool:
        """Return whether to request a chunk for the observation of this step."""
        if self._asked is not None:
            return False
        return self._options.ensemble is not None or step + self._delay >= self._next

    def ask(self, step: int) -> None:
        """Record that a chunk was requested for the observation of this step."""
        self._asked = step

    def add(self, actions: Array, step: int) -> None:
        """Add a chunk, shape (h, m), that has been received by this step."""
        assert self._asked is not None
        self._delay = step - self._asked
        first = self._asked if self._options.compensate else step
        self._asked = None
        chunk = _Chunk(first, actions)
        if self._options.ensemble is None:
            self._chunks = [chunk]
        else:
            self._chunks.append(chunk)
        length = len(actions)
        self._next = first + min(self._options.execute or length, length)

    def action(self, step: int) -> Array | None:
        """Return the action for this step, shape (m,); None if no chunk covers it."""
        self._chunks = [chunk for chunk in self._chunks if chunk.end > step]
        found = [
            chunk.actions[step - chunk.first]
            for chunk in self._chunks
            if chunk.first <= step
        ]
        if not found:
            return None
        weights = np.exp(-(self._options.ensemble or 0.0) * np.arange(len(found)))
        return np.asarray(weights @ np.stack(found) / weights.sum())
