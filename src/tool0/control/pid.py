"""The PID law of ROS's control_toolbox, for several joints at once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from tool0.errors import ConfigError


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Gains:
    """Gains from joint units to command units.

    As in control_toolbox, an integral without a clamp contributes nothing.
    """

    p: float
    i: float = 0.0
    d: float = 0.0
    i_min: float = 0.0
    """Least contribution of the integral, at most 0."""
    i_max: float = 0.0
    """Greatest contribution of the integral, at least 0."""
    antiwindup: bool = False
    """Clamp the integral itself, not only its contribution."""

    def __post_init__(self) -> None:
        if not all(map(math.isfinite, (self.p, self.i, self.d))):
            raise ConfigError(f"gains must be finite numbers, got {self}")
        if not self.i_min <= 0.0 <= self.i_max:
            raise ConfigError(f"need i_min <= 0 <= i_max, got {self}")


@final
class Pid:
    """Per joint: ``p e + clamp(i ∫e dt) + d de/dt``; no filter, no output clamp.

    A period of zero gives 0 and leaves the integral.  The errors must be finite, which
    the engine (DivergenceError) and the checks of goals and commands ensure.
    """

    __slots__ = ("_integrals", "_rows")

    def __init__(self, gains: Sequence[Gains]) -> None:
        self._rows = [
            (k, g.p, g.i, g.d, g.i_min, g.i_max, g.antiwindup)
            for k, g in enumerate(gains)
        ]
        self._integrals = [0.0] * len(self._rows)

    def update(
        self, errors: Sequence[float], error_rates: Sequence[float], period: float
    ) -> list[float]:
        """Return a command per joint."""
        if not period > 0.0:
            return [0.0] * len(self._rows)
        integrals = self._integrals
        commands: list[float] = []
        for k, p, i, d, i_min, i_max, antiwindup in self._rows:
            error = errors[k]
            integrals[k] = integral = integrals[k] + period * error
            term = i * integral
            if term > i_max:
                term = i_max
                if antiwindup:
                    integrals[k] = term / i
            elif term < i_min:
                term = i_min
                if antiwindup:
                    integrals[k] = term / i
            commands.append(p * error + term + d * error_rates[k])
        return commands
