"""The PID law of ROS's control_toolbox, for one joint and for several at once."""

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
    """Clamp the integral itself, not only what it contributes."""

    def __post_init__(self) -> None:
        if not all(map(math.isfinite, (self.p, self.i, self.d))):
            raise ConfigError(f"gains must be finite numbers, got {self}")
        if not self.i_min <= 0.0 <= self.i_max:
            raise ConfigError(f"need i_min <= 0 <= i_max, got {self}")


@final
class Pid:
    """One joint's law: ``p e + clamp(i ∫e dt) + d de/dt``; no filter, no output clamp.

    An error that is not finite, or a period of zero, gives 0 and leaves the integral.
    """

    __slots__ = ("_gains", "_integral", "_last_error")

    def __init__(self, gains: Gains) -> None:
        self._gains = gains
        self._integral = 0.0
        self._last_error = 0.0

    def update(self, error: float, error_rate: float, period: float) -> float:
        """Return the command for an error and its rate of change."""
        if not (period > 0.0 and math.isfinite(error) and math.isfinite(error_rate)):
            return 0.0
        gains = self._gains
        self._integral += period * error
        integral_term = gains.i * self._integral
        clamped = min(max(integral_term, gains.i_min), gains.i_max)
        if gains.antiwindup and clamped != integral_term:
            self._integral = clamped / gains.i
        return gains.p * error + clamped + gains.d * error_rate

    def update_from_error(self, error: float, period: float) -> float:
        """Return the command, with the rate taken from the last two errors.

        As in control_toolbox the error before the first is taken as 0.
        """
        if not (period > 0.0 and math.isfinite(error)):
            return 0.0
        error_rate = (error - self._last_error) / period
        self._last_error = error
        return self.update(error, error_rate, period)


@final
class PidBank:
    """The law of ``Pid``, error and rate given, over several joints in one loop.

    Made for the tick: the errors must be finite, which the engine (DivergenceError)
    and the checks on goals see to.
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
