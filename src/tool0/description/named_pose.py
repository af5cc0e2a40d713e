"""Positions of joints under a name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

Positions = Mapping[str, float]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class NamedPose:
    """Positions of some or all joints, under a name."""

    name: str
    """Name such as ``home``."""
    positions: Positions
    """Joint → [rad | m]."""
    saved: bool
    """Whether a user saved it."""
