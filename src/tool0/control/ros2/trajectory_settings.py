"""Replacement and speed of trajectories of a ROS 2 controller."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final

from tool0.errors import ControlError


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Replacement:
    """Rules by which a trajectory replaces the one that is being executed."""

    is_spliced: bool = True
    """``allow_trajectory_replacement``: whether a new trajectory continues the desired
    motion from its start on, while joints that it does not name continue theirs.
    Otherwise, all previous motion ends at once."""
    from_desired: bool = False
    """``interpolate_from_desired_state``: whether motions start from the desired
    instead of the measured motion."""
    is_stepped: bool = False
    """``interpolation_method: none``: whether points are commanded as they are."""
    upsamples: bool = False
    """``positions_upsampling.enable``: whether positions from the topic are
    smoothed."""
    policy_frequency: float = 0.0
    """Rate that determines the times of points without times [Hz]; 0 for none."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedSource:
    """Source of the speed factor of trajectories."""

    initial: float = 1.0
    """Factor until the topic sets another one."""
    is_settable: bool = True
    """Whether the topic may set the factor, which requires that only positions are
    commanded."""
    factors: Mapping[str, float] = field(default_factory=dict)
    """Current factors of the arms, by prefix."""
    prefix: str | None = None
    """Prefix of the arm whose factor applies; None for the topic's factor."""

    def factor(self, settable: float) -> float:
        """Return the factor in effect; ``settable`` is the factor of the topic."""
        return settable if self.prefix is None else self.factors.get(self.prefix, 1.0)

    def check(self, factor: float, controller: str) -> None:
        """Raise ControlError if the topic of a controller cannot set this factor."""
        if not 0.0 <= factor < math.inf:
            raise ControlError(
                "Scaling factor has to be greater or equal to 0.0 - Ignoring input! "
                f"Got {factor}"
            )
        if not self.is_settable:
            raise ControlError(
                f"the speed of '{controller}' cannot be scaled: only controllers that "
                "command nothing but positions can scale it"
            )
        if self.prefix is not None:
            raise ControlError(
                f"the speed of '{controller}' is scaled by the control box, as "
                "'speed_scaling/state_interface' says; set its speed slider"
            )
