"""Replacement and speed of the trajectories of a controller of ROS 2."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final

from tool0.errors import ControlError


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Replacement:
    """Rules by which a trajectory replaces the one in execution."""

    is_spliced: bool = True
    """``allow_trajectory_replacement``: it follows the desired motion where it starts,
    and joints that it does not name go on.  Otherwise everything ends at once."""
    from_desired: bool = False
    """``interpolate_from_desired_state``, not from the measured motion."""
    is_stepped: bool = False
    """``interpolation_method: none``: the points are sent as they are."""
    upsamples: bool = False
    """``positions_upsampling.enable``: positions of the topic become smooth."""
    policy_frequency: float = 0.0
    """Rate of points without times [Hz]; 0 is none."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedSource:
    """Source of the factor of the trajectories' speed."""

    initial: float = 1.0
    """The factor until the topic sets another one."""
    is_settable: bool = True
    """Whether the topic may: only if nothing but positions is commanded."""
    factors: Mapping[str, float] = field(default_factory=dict)
    """The present factors of the arms, by prefix."""
    prefix: str | None = None
    """Prefix of the arm whose factor counts; None for the topic's factor."""

    def factor(self, settable: float) -> float:
        """Return trajectory time per simulated time; ``settable`` is the topic's."""
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
