"""Additional inputs of a network, for tasks that need a precision of tenths of a mm.

A network has difficulty in learning small distances from inputs that are normalized by
their standard deviation, which is some centimeters, and differences of angles from
quaternions.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import final

import numpy as np
from numpy.typing import NDArray

from tool0.description.transform_arrays import yaws_of_quats

SCALES = (0.001, 0.005, 0.02)
"""Distances at which the inputs saturate [m]."""
TURN = 0.05
"""Sine of four times an angle at which an input saturates."""

Array = NDArray[np.float64]


@final
class FineInputs:
    """Inputs for small distances and for the angles between objects and tools."""

    def __init__(self, names: Sequence[str]) -> None:
        """Find the distances and orientations among the names of a state's numbers."""
        axes = tuple(
            i
            for i, name in enumerate(names)
            if "to_" in name and name.endswith((".x", ".y", ".z"))
        )
        self._distances = np.array(axes, dtype=int)
        quats = [i for i, name in enumerate(names) if name.endswith(".qw")]
        tools = [i for i in quats if names[i].endswith("tcp.qw")]
        objects = [i for i in quats if i not in tools]
        pairs = [
            *itertools.product(tools, objects),
            *itertools.product(objects[:1], objects[1:]),
        ]
        self._pairs = [tuple(slice(i, i + 4) for i in pair) for pair in pairs]

    def __call__(self, states: Array) -> Array:
        """Return states (n, m), extended by the additional inputs, shape (n, k).

        The inputs are the distances, saturated at each of the SCALES, and the sines and
        cosines of the differences of yaws and of four times these differences, since
        cubes and square pegs look the same after a quarter turn.
        """
        distances = states[:, self._distances]
        found = [states, *(np.tanh(distances / scale) for scale in SCALES)]
        for one, other in self._pairs:
            turn = yaws_of_quats(states[:, one]) - yaws_of_quats(states[:, other])
            sine = np.sin(4.0 * turn)
            columns = (np.sin(turn), np.cos(turn), sine, np.cos(4.0 * turn))
            found.append(np.column_stack([*columns, np.tanh(sine / TURN)]))
        return np.concatenate(found, axis=1)
