"""What makes the present state of copies again: starts of episodes, and actions."""

from __future__ import annotations

import copy
from collections import deque
from collections.abc import Sequence
from typing import Final, Protocol, final

import numpy as np

from tool0.errors import ControlError
from tool0.gym.task import Mask
from tool0.kinematics.chain import Array

LONGEST: Final = 10_000
"""Actions of an episode that can be repeated."""


class Acting(Protocol):
    """Copies that can be reset and act."""

    def reset(self, which: Mask, generators: Sequence[np.random.Generator]) -> None:
        """Start new episodes of the copies in ``which``, shape (n,)."""

    def act(self, actions: Array) -> None:
        """Advance all copies by one control period."""


@final
class History:
    """The present episode of each copy.  An episode does not depend on others."""

    def __init__(self, n: int) -> None:
        self._starts: list[np.random.Generator | None] = [None] * n
        self._begun = np.zeros(n, np.int64)
        """Number of the first action of each episode."""
        self._actions: deque[Array] = deque(maxlen=LONGEST)
        self._count = 0
        """Actions so far, with those that are forgotten."""

    def begin(self, which: Mask, generators: Sequence[np.random.Generator]) -> None:
        """Note the start of episodes, whose draws follow from the generators."""
        for i in np.flatnonzero(which).tolist():
            self._starts[i] = copy.deepcopy(generators[i])
        self._begun[which] = self._count
        while self._count - len(self._actions) < self._begun.min() and self._actions:
            self._actions.popleft()

    def add(self, actions: Array) -> None:
        """Note an action of all copies, shape (n, m)."""
        self._actions.append(actions)
        self._count += 1

    def repeat(self, copies: Acting) -> None:
        """Bring new copies into the same state.

        Raises:
            ControlError: If an episode has too many actions.
        """
        first = self._count - len(self._actions)
        if (self._begun < first).any():
            raise ControlError(
                f"an environment can be copied up to {LONGEST} actions after its reset"
            )
        generators = [
            copy.deepcopy(start or np.random.default_rng()) for start in self._starts
        ]
        has_started = np.array([start is not None for start in self._starts])
        for number in range(first, self._count + 1):
            begins = has_started & (self._begun == number)
            if begins.any():
                copies.reset(begins, generators)
            if number < self._count:
                copies.act(self._actions[number - first])
