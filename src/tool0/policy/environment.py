"""Interface of environments in which a policy acts: a task or a running robot."""

from __future__ import annotations

from typing import NamedTuple, Protocol, final

import numpy as np
from numpy.typing import NDArray

from tool0.errors import PolicyError
from tool0.policy.seen import Seen

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

TOLERANCE = 0.1
"""Largest amount by which a component of an action may exceed its limits and still be
clipped, as a fraction of the component's range.  Larger excesses are rejected."""


@final
class ActionRefusedError(PolicyError):
    """Raised for an action beyond the limits, which is rejected before any motion."""


class Outcome(NamedTuple):
    """Result of an action."""

    reward: float = 0.0
    terminated: bool = False
    """Whether the episode has ended according to the rules of the task."""
    truncated: bool = False
    """Whether the time limit was reached, or the physics failed."""
    success: bool | None = None
    """Whether the task has succeeded; None if it is unknown."""


class Environment(Protocol):
    """Source of observations and executor of one action per control period."""

    @property
    def rate(self) -> float:
        """Actions per simulated second [Hz]."""

    @property
    def is_realtime(self) -> bool:
        """Whether time continues while a policy computes."""

    @property
    def action_names(self) -> tuple[str, ...]:
        """Names of the m components of an action."""

    @property
    def limits(self) -> tuple[Array, Array]:
        """Lower and upper limits of actions, each of shape (m,)."""

    def begin(self, seed: int) -> None:
        """Begin an episode."""

    def see(self) -> Seen:
        """Return the current observation of the environment."""

    def hold(self) -> Array:
        """Return the action that keeps the robot stationary, shape (m,)."""

    def act(self, action: Array) -> Outcome:
        """Execute an action for one control period.

        Raises:
            ActionRefusedError: If the action would move a joint too far in one control
                period.
            ControlError: If the robot refuses the action.
        """

    def picture(self) -> Picture | None:
        """Return an image for videos, shape (height, width, 3), or None."""

    def end(self) -> None:
        """End the episode and stop all motion."""

    def close(self) -> None:
        """Close the environment."""


def within_limits(
    action: Array, environment: Environment, *, clips: bool = False
) -> Array:
    """Return an action within the limits.

    Args:
        action: The action, shape (m,).
        environment: Environment that executes the action.
        clips: Whether to also clip actions that are far beyond the limits.

    Raises:
        ActionRefusedError: If the action is not finite, or is far beyond the limits and
            ``clips`` is False.
    """
    low, high = environment.limits
    names = environment.action_names
    if not np.isfinite(action).all():
        k = int(np.argmin(np.isfinite(action)))
        raise ActionRefusedError(f"the action for '{names[k]}' is {action[k]}")
    excess = np.maximum(low - action, action - high) / (high - low)
    k = int(np.argmax(excess))
    if excess[k] > TOLERANCE and not clips:
        raise ActionRefusedError(
            f"the action for '{names[k]}' is {action[k]:.4g}; it must be "
            f"{low[k]:.4g} … {high[k]:.4g}"
        )
    return np.asarray(np.clip(action, low, high))
