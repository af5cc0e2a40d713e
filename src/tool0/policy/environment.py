"""Environments that a policy drives: an episode of a task, or a running robot."""

from __future__ import annotations

from typing import NamedTuple, Protocol, final

import numpy as np
from numpy.typing import NDArray

from tool0.errors import PolicyError
from tool0.policy.seen import Seen

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

TOLERANCE = 0.1
"""Part of its range by which a number of an action may be beyond its limits and is only
clipped: networks overshoot a little."""


@final
class ActionRefusedError(PolicyError):
    """An action that is beyond the limits: nothing has moved by it."""


class Outcome(NamedTuple):
    """Result of an action."""

    reward: float = 0.0
    terminated: bool = False
    """Whether the episode has ended by the task's own rules."""
    truncated: bool = False
    """Whether its time is over, or its physics failed."""
    success: bool | None = None
    """Whether the task is done; None if nothing says so."""


class Environment(Protocol):
    """Observes, and takes one action per control period."""

    @property
    def rate(self) -> float:
        """Actions per simulated second [Hz]."""

    @property
    def is_realtime(self) -> bool:
        """Whether time passes while a policy computes."""

    @property
    def action_names(self) -> tuple[str, ...]:
        """Meaning of each of the m numbers of an action."""

    @property
    def limits(self) -> tuple[Array, Array]:
        """Least and greatest actions, each of shape (m,)."""

    def begin(self, seed: int) -> None:
        """Begin an episode."""

    def see(self) -> Seen:
        """Return what is observed now."""

    def hold(self) -> Array:
        """Return the action that moves nothing, shape (m,)."""

    def act(self, action: Array) -> Outcome:
        """Act for one control period.

        Raises:
            ActionRefusedError: If it would move something too far.
            ControlError: If the robot does not take it.
        """

    def picture(self) -> Picture | None:
        """Return a picture for videos, shape (height, width, 3), if there are any."""

    def end(self) -> None:
        """End the episode; what moved stops."""

    def close(self) -> None:
        """End it."""


def within_limits(
    action: Array, environment: Environment, *, clips: bool = False
) -> Array:
    """Return an action within the limits.

    Args:
        action: Shape (m,).
        environment: Environment that takes it.
        clips: Whether one that is far beyond is clipped, too.

    Raises:
        ActionRefusedError: If it is far beyond, or not finite.
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
