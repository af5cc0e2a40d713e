"""Saved states of copies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, final

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
