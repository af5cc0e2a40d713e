"""Saved states of copies, and the check of a state before copies are restored."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, final

import numpy as np
from numpy.typing import ArrayLike

from tool0.batch.arguments import Arguments, Indices
from tool0.errors import ControlError

if TYPE_CHECKING:
    from tool0.batch.copy_sensor import SavedSensor, SensorKind
    from tool0.batch.images import CopyLook
    from tool0.engines.mujoco.engine import SavedEngine
    from tool0.simulation.core import SavedCore


@final
@dataclass(frozen=True, slots=True)
class SavedCopy:
    """State of one copy at one instant."""

    core: SavedCore
    engine: SavedEngine
    has_diverged: bool
    sensors: Mapping[SensorKind, SavedSensor] = field(default_factory=dict)
    """State of the force-torque sensors that were running."""


@final
@dataclass(frozen=True, slots=True)
class BatchState:
    """State of n copies, returned by ``Batch.save`` for use with ``Batch.restore``."""

    copies: Sequence[SavedCopy] = field(repr=False)
    """State of each copy."""
    looks: Sequence[CopyLook] = field(repr=False)
    """Appearance of the copies in images."""
    dt: float
    """Length of a physics step [s]."""

    @property
    def n(self) -> int:
        """Number of copies."""
        return len(self.copies)


def checked_sources(
    state: BatchState,
    source: ArrayLike | None,
    rows: Indices,
    check: Arguments,
    *,
    n: int,
    dt: float,
) -> list[int]:
    """Return the number of the saved copy for each row.

    Args:
        state: The saved state.
        source: Numbers of saved copies, shape (n,) (default: the number of each copy).
        rows: Numbers of the copies to restore.
        check: Checks of the arguments of the method.
        n: Number of copies of the batch.
        dt: Length of a physics step of the batch [s].

    Raises:
        ControlError: If a number is not the number of a saved copy, or the state has
            steps of another length.
    """
    given = np.arange(n) if source is None else source
    sources = check.rows("source", given, (), rows)[rows].tolist()
    for number in sources:
        if number not in range(state.n):
            raise ControlError(
                f"Batch.restore: 'source' names copy {number:g}; the state has "
                f"0 … {state.n - 1}"
            )
    if state.dt != dt:
        raise ControlError(
            f"Batch.restore: the state is of steps of {state.dt} s, but this batch "
            f"has steps of {dt} s"
        )
    return [int(number) for number in sources]
