"""Rules for the replacement and the speed of a ROS 2 controller's trajectories."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final

from tool0.errors import ControlError


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Replacement:
    """Rules for the replacement of a trajectory that is being executed."""

    is_spliced: bool = True
    """``allow_trajectory_replacement``: whether a new trajectory, when it starts,
    continues the desired motion, while joints that it does not contain continue their
    own motion.  If the parameter is false, all previous motion ends immediately."""
    from_desired: bool = False
    """``interpolate_from_desired_state``: whether trajectories start from the desired
    motion instead of the measured motion."""
    is_stepped: bool = False
    """``interpolation_method: none``: whether points are commanded without
    interpolation."""
    upsamples: bool = False
    """``positions_upsampling.enable``: whether positions from the topic are
    interpolated smoothly."""
    policy_frequency: float = 0.0
    """Rate that determines the times of points without times [Hz]; 0 if there is no
    such rate."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedSource:
    """Source of the speed factor of trajectories."""

    initial: float = 1.0
    """Speed factor until the topic sets another factor."""
    is_settable: bool = True
    """Whether the topic may set the factor.  The topic may set the factor only if the
    controller has no command interfaces other than position."""
    factors: Mapping[str, float] = field(default_factory=dict)
    """Current speed factors of the arms, by prefix."""
    prefix: str | None = None
    """Prefix of the arm with the applicable factor; None for the factor of the
    topic."""

    def factor(self, settable: float) -> float:
        """Return the factor in effect; ``settable`` is the factor of the topic."""
        return settable if self.prefix is None else self.factors.get(self.prefix, 1.0)

    def check(self, factor: float, controller: str) -> None:
        """Raise ControlError if the topic of a controller cannot set ``factor``."""
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
