"""Observations of n copies, and the observation spaces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from tool0.gym.bounds import FARTHEST
from tool0.gym.copies import Copies
from tool0.gym.parts import parts, values
from tool0.kinematics.chain import Array

Observation = Array | dict[str, NDArray[Any]]
"""One array, or one array per key.  The first axis is indexed by the copy."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class NumberNames:
    """Names of the numbers of observations and actions."""

    observations: Mapping[str, tuple[str, ...]]
    """Names of the numbers by key of the observation; the key is ``""`` if there is
    only one array."""
    surroundings: frozenset[str]
    """Names of the numbers that the robot's sensors do not measure, such as poses of
    objects and goals."""
    action: tuple[str, ...]
    grippers: tuple[int, ...] = ()
    """Indices of the gripper openings in an action."""


@final
class Observer:
    """Makes observations, in which numbers are float64 and RGB images are uint8."""

    def __init__(self, copies: Copies) -> None:
        self._copies = copies
        self._mode = copies.options.observation
        found = parts(copies)
        self._low = np.concatenate([part.low for part in found])
        self._high = np.concatenate([part.high for part in found])
        ends = np.cumsum([len(part.low) for part in found]).tolist()
        self.slices = {
            part.name: slice(end - len(part.low), end)
            for part, end in zip(found, ends, strict=True)
        }
        """The slice of each part in the state."""
        self.names = _names(copies)
        """Names of the numbers of observations and actions."""

    @property
    def space(self) -> spaces.Space[Any]:
        """The observation space of one copy."""
        state = spaces.Box(self._low, self._high, dtype=np.float64)
        if self._mode == "state":
            return state
        if self._mode == "dict":
            boxes: dict[str, spaces.Space[Any]] = {
                name: spaces.Box(self._low[part], self._high[part], dtype=np.float64)
                for name, part in self.slices.items()
            }
            return spaces.Dict(boxes)
        if self._mode == "goal":
            names = self._copies.task.goal_names
            goal = spaces.Box(-FARTHEST, FARTHEST, (len(names),), np.float64)
            return spaces.Dict(
                {"observation": state, "achieved_goal": goal, "desired_goal": goal}
            )
        return spaces.Dict({"state": state, **self._image_spaces()})

    def _image_spaces(self) -> dict[str, spaces.Space[Any]]:
        options = self._copies.options
        width, height = options.image_size
        found: dict[str, spaces.Space[Any]] = {}
        shape = height, width
        for keys in options.image_keys.values():
            found[keys.rgb] = spaces.Box(0, 255, (*shape, 3), np.uint8)
            if options.depth:
                found[keys.depth] = spaces.Box(0.0, FARTHEST, shape, np.float32)
            if options.segmentation:
                most = len(self._copies.batch.object_names) - 1
                found[keys.segmentation] = spaces.Box(-3, most, shape, np.int32)
        return found

    def observe(self) -> Observation:
        """Return the current observations of the copies as new arrays."""
        copies = self._copies
        numbers = np.concatenate(values(copies), axis=1)
        state: Array = np.minimum(np.maximum(numbers, self._low), self._high)
        if self._mode == "state":
            return state
        if self._mode == "dict":
            return {name: state[:, part].copy() for name, part in self.slices.items()}
        if self._mode == "goal":
            achieved, desired = copies.goals()
            return {
                "observation": state,
                "achieved_goal": achieved.clip(-FARTHEST, FARTHEST),
                "desired_goal": desired.clip(-FARTHEST, FARTHEST),
            }
        return {"state": state, **copies.images()}


def row(observation: Observation, i: int) -> Any:  # an array, or a dict of arrays
    """Return a copy of the observation of copy ``i``."""
    if isinstance(observation, dict):
        return {name: array[i].copy() for name, array in observation.items()}
    return observation[i].copy()


def _names(copies: Copies) -> NumberNames:
    found = parts(copies)
    state = tuple(name for part in found for name in part.columns)
    around = [name for part in found if not part.of_robot for name in part.columns]
    goals = {
        key: tuple(f"{key}.{name}" for name in copies.task.goal_names)
        for key in ("achieved_goal", "desired_goal")
    }
    return NumberNames(
        observations={
            "state": {"": state},
            "dict": {part.name: part.columns for part in found},
            "goal": {"observation": state, **goals},
            "image": {"state": state},
        }[copies.options.observation],
        surroundings=frozenset(
            [*around, *(n for names in goals.values() for n in names)]
        ),
        action=copies.actions.names,
        grippers=copies.actions.grippers,
    )
