"""A device in a person's hand: shares of the tool's speed, the gripper, and events."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from lerobot.teleoperators.utils import TeleopEvents
from numpy.typing import NDArray

Array = NDArray[np.float64]
Grip = Literal["open", "close"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """One reading of a device."""

    shares: Array
    """Of the largest speed along x, y, z and about them, -1 … 1, shape (6,): x is
    forward, y left, z up.  Zeros are neutral."""
    grip: Grip | None = None
    """The gripper button that was pressed since the last reading."""
    events: frozenset[TeleopEvents] = frozenset()
    """The ends of an episode that were chosen since the last reading."""


class Device(Protocol):
    """A gamepad or a SpaceMouse."""

    def read(self) -> Command | None:
        """Return the command now, without waiting; None while it is unplugged."""

    def close(self) -> None:
        """Let go of it."""


def beyond_dead_zone(deflections: Array, dead_zone: float) -> Array:
    """Return deflections without their dead zone, -1 … 1, from 0 at its edge on."""
    beyond = (np.abs(deflections) - dead_zone) / (1.0 - dead_zone)
    return np.sign(deflections) * beyond.clip(0.0, 1.0)
