"""The observation of one step, in the forms in which policies want it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from tool0.collect.lerobot import observation_columns

Array = NDArray[Any]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """Observation before one action."""

    observation: Any
    """Observation as the environment gives it: an array, or a dictionary."""
    values: Mapping[str, Array]
    """The same by name; ``""`` if it is one array."""
    kept: Mapping[str, Array]
    """Parts of these that are kept after the action."""
    names: Mapping[str, Sequence[str]]
    """Name of an observation → names of its numbers."""
    surroundings: frozenset[str]
    """Names of the numbers that the robot does not measure on itself."""
    instruction: str
    """Description of the task."""

    def columns(self) -> dict[str, Array]:
        """Return the observation as LeRobot's data sets name it.

        ``observation.state`` and ``observation.environment_state``, shape (m,),
        float32; ``observation.images.NAME``, shape (height, width, 3), uint8.

        Raises:
            CollectError: If the format has no column for something.
        """
        return self._columns()[0]

    def numbers(self) -> dict[str, float]:
        """Return the numbers by name, such as ``elbow_joint.position``."""
        columns, names = self._columns()
        return {
            name: float(value)
            for place, each in names.items()
            for name, value in zip(each, columns.get(place, ()), strict=True)
        }

    def _columns(self) -> tuple[dict[str, Array], dict[str, list[str]]]:
        frames = {name: np.asarray(value)[None] for name, value in self.values.items()}
        columns, names = observation_columns(frames, self.names, self.surroundings)
        return {name: values[0] for name, values in columns.items()}, names
