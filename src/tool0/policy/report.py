"""Statistics of many episodes of a policy."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, TypedDict, final

import numpy as np

from tool0.policy.running import EpisodeRun

_Z: Final = 1.959963984540054
"""Quantile 0.975 of the normal distribution, for 95 % confidence intervals."""


class PolicyTimeJson(TypedDict):
    """Wall times of a policy's answers."""

    median: float
    """Median [wall s]."""
    p95: float
    """95 % quantile [wall s]."""
    longest: float
    """Maximum [wall s]."""


class ReportJson(TypedDict):
    """The report as values that JSON can represent."""

    episodes: int
    """Number of completed episodes."""
    succeeded: int
    """Number of episodes that succeeded."""
    stopped: int
    """Number of episodes that ended with an action beyond the limits, which are counted
    as failures."""
    success_rate: float | None
    """Fraction of episodes that succeeded; null if there are no episodes."""
    interval: list[float]
    """Bounds of the 95 % confidence interval of the true success rate."""
    mean_steps: float
    """Mean number of actions per episode."""
    policy_time: PolicyTimeJson
    """Time that the policy's answers took."""
    held_steps: int
    """Number of steps in all episodes in which no action had been received yet."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """Statistics of episodes with different seeds."""

    n_episodes: int
    """Number of completed episodes, excluding one that the user interrupted."""
    n_succeeded: int
    n_stopped: int
    """Number of episodes that ended with an action beyond the limits, which are counted
    as failures."""
    mean_steps: float
    """Mean number of actions per episode."""
    policy_time: tuple[float, float, float]
    """Median, 95 % quantile and maximum of the wall time of the policy's answers
    [s]."""
    n_held: int
    """Number of steps, summed over all episodes, in which no action had been received
    yet."""

    @property
    def success_rate(self) -> float:
        """Fraction of episodes that succeeded; NaN if there are no episodes."""
        return self.n_succeeded / self.n_episodes if self.n_episodes else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % confidence interval of the true success rate; see ``wilson``."""
        return wilson(self.n_succeeded, self.n_episodes)

    def as_json(self) -> ReportJson:
        """Return the report as values that JSON can represent."""
        low, high = self.interval
        median, most, longest = self.policy_time
        return {
            "episodes": self.n_episodes,
            "succeeded": self.n_succeeded,
            "stopped": self.n_stopped,
            "success_rate": self.success_rate if self.n_episodes else None,
            "interval": [low, high],
            "mean_steps": self.mean_steps,
            "policy_time": {"median": median, "p95": most, "longest": longest},
            "held_steps": self.n_held,
        }


def report_of(runs: Sequence[EpisodeRun]) -> Report:
    """Return the statistics of episodes."""
    ended = [run for run in runs if run.result != "interrupted"]
    results = Counter(run.result for run in ended)
    latencies = [latency for run in runs for latency in run.latencies] or [0.0]
    median, most = np.quantile(latencies, [0.5, 0.95]).tolist()
    return Report(
        n_episodes=len(ended),
        n_succeeded=results["success"],
        n_stopped=results["stopped"],
        mean_steps=float(np.mean([run.n_steps for run in ended] or [0])),
        policy_time=(median, most, max(latencies)),
        n_held=sum(run.n_held for run in runs),
    )


def wilson(n_succeeded: int, n: int) -> tuple[float, float]:
    """Return the 95 % confidence interval of a success rate.

    The result is Wilson's score interval (Wilson 1927,
    doi:10.1080/01621459.1927.10502953), which is valid for few episodes and for rates
    near 0 and 1.
    """
    if n == 0:
        return 0.0, 1.0
    rate, z2 = n_succeeded / n, _Z * _Z
    middle = (rate + z2 / (2 * n)) / (1 + z2 / n)
    spread = rate * (1 - rate) / n + z2 / (4 * n * n)
    half = _Z * math.sqrt(spread) / (1 + z2 / n)
    low, high = max(0.0, middle - half), min(1.0, middle + half)
    return (0.0 if n_succeeded == 0 else low), (1.0 if n_succeeded == n else high)
