"""The observation of one step, in the forms that policies require."""

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
    """The observation before one action."""

    observation: Any
    """Observation in the form of the environment: an array or a dictionary."""
    values: Mapping[str, Array]
    """Arrays of the observation by name; the name is ``""`` if there is a single
    array."""
    kept: Mapping[str, Array]
    """Arrays of the observation that are recorded with the action."""
    names: Mapping[str, Sequence[str]]
    """Names of the numbers in each array, by the array's name."""
    surroundings: frozenset[str]
    """Names of the numbers that the robot's sensors cannot measure."""
    instruction: str
    """Description of the task."""

    def columns(self) -> dict[str, Array]:
        """Return the observation with the column names of LeRobot's data sets.

        The columns ``observation.state`` and ``observation.environment_state`` are
        float32 arrays of shape (m,).  The columns ``observation.images.NAME`` are uint8
        arrays of shape (height, width, 3).

        Raises:
            CollectError: If LeRobot's format has no column for a part of the
                observation.
        """
        return self._columns()[0]

    def numbers(self) -> dict[str, float]:
        """Return the observed numbers by name, such as ``elbow_joint.position``."""
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
