"""Policies of the tests of ``tool0 policy``."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]
TO_GOAL = slice(-3, None)
"""Where a state of Reach has the way from the tcp to the goal [m]."""


class Reach:
    """Moves towards the goal; the gripper stays open."""

    def __init__(self, seed: int) -> None:
        self.seed = seed

    def __call__(self, state: Array) -> Array:
        way = np.clip(state[TO_GOAL] / 0.02, -1.0, 1.0)
        return np.array([*way, 0.0, 1.0])


class ReachFar(Reach):
    """The same actions for the next 20 steps: too far if all are executed."""

    def __call__(self, state: Array) -> Array:
        return np.tile(super().__call__(state), (20, 1))


class Overshooting(Reach):
    def __call__(self, state: Array) -> Array:
        return super().__call__(state) * 3.0


class NotANumber(Reach):
    def __call__(self, state: Array) -> Array:
        return np.full(5, np.nan)


class TooShort(Reach):
    def __call__(self, state: Array) -> Array:
        return np.zeros(3)


class Failing(Reach):
    def __call__(self, state: Array) -> Array:
        raise KeyError("weights")


class Wave:
    """A robot's: moves the fifth joint by a sine, and closes the gripper slowly."""

    n = 10
    amplitude = 0.2

    def __init__(self, seed: int) -> None:
        self.start: Array | None = None
        self.step = 0

    def __call__(self, seen: dict[str, Array]) -> Array:
        if self.start is None:
            self.start = seen["position"].copy()
        steps = self.step + 1 + np.arange(self.n)
        self.step += self.n
        actions = np.tile(self.start, (self.n, 1))
        actions[:, 4] += self.amplitude * np.sin(2.0 * np.pi * 0.5 * steps / 25.0)
        actions[:, 6] = 0.01 * steps
        return actions


class Looking:
    """Holds still; fails without an image that shows something."""

    def __init__(self, seed: int) -> None:
        pass

    def __call__(self, seen: dict[str, Array]) -> Array:
        image = seen["wrist"]
        assert image.dtype == np.uint8
        assert np.ptp(image) > 50
        return seen["position"]


class Jump:
    def __init__(self, seed: int) -> None:
        pass

    def __call__(self, seen: dict[str, Array]) -> Array:
        action = seen["position"].copy()
        action[0] += 1.0
        return action


is_answered = threading.Event()
"""Set by a test that lets ``Waiting`` answer."""


class Waiting(Wave):
    """Answers the second time only when a test says so."""

    amplitude = 0.02  # no jump, whenever it goes on

    def __call__(self, seen: dict[str, Array]) -> Array:
        if self.step:
            is_answered.wait(10.0)
        return super().__call__(seen)
