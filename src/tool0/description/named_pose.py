"""Named joint positions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

Positions = Mapping[str, float]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class NamedPose:
    """Named positions of some or all joints."""

    name: str
    """Name of the pose, such as ``home``."""
    positions: Positions
    """Positions by joint name [rad | m]."""
    saved: bool
    """Whether a user saved the pose.  Poses that are not saved are built in."""
