"""Chunks of actions: when to ask for the next one, and which action is next.

A policy answers an observation with the actions of the next steps.  Its answer may come
some steps after the observation; the actions of these are late, and are skipped.
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
    """Options of executing chunks of actions."""

    execute: int | None = None
    """Actions of a chunk that are executed before the next chunk replaces it; all of
    them if not given."""
    ensemble: float | None = None
    """Ask in each step, and execute the mean of all predictions for it: the weight of
    the i-th oldest is exp(-ensemble · i), as ACT has it (Zhao et al. 2023)."""
    compensate: bool = True
    """Whether the actions of steps that are over when a chunk arrives are skipped."""

    def __post_init__(self) -> None:
        """Check the values.

        Raises:
            ConfigError: If one is out of range, or both are given.
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
    """Step of its first action."""
    actions: Array
    """Shape (h, m)."""

    @property
    def end(self) -> int:
        return self.first + len(self.actions)


@final
class Chunks:
    """The chunks of one episode, by the number of the step."""

    def __init__(self, options: ChunkOptions) -> None:
        self._options = options
        self._chunks: list[_Chunk] = []
        self._asked: int | None = None
        self._next = 0
        """First step for which the next chunk is needed."""
        self._delay = 0
        """Steps that the last answer took."""

    def wants(self, step: int) -> bool:
        """Return whether to ask for a chunk with the observation of this step."""
        if self._asked is not None:
            return False
        return self._options.ensemble is not None or step + self._delay >= self._next

    def ask(self, step: int) -> None:
        """Note that a chunk was asked for with the observation of this step."""
        self._asked = step

    def add(self, actions: Array, step: int) -> None:
        """Take a chunk, shape (h, m), that arrives in time for this step."""
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
        """Return the action of this step, shape (m,); None if there is none."""
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
