"""Sources of policies: a Python callable, a LeRobot policy, or a server."""

from __future__ import annotations

from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from tool0.collect.policy import Policy
from tool0.errors import ConfigError, PolicyError
from tool0.policy.seen import Seen

Array = NDArray[np.float64]

LEROBOT: Final = "lerobot:"
_SERVERS: Final = ("ws://", "wss://")


class Source(Protocol):
    """Policy that answers observations with actions, for one user at a time."""

    @property
    def digest(self) -> str | None:
        """SHA-256 of the file that defines the policy; None if no file defines it."""

    def begin(self, seed: int) -> None:
        """Begin an episode."""

    def infer(self, seen: Seen) -> Any:
        """Return the next actions, shape (m,) or (h, m).

        Raises:
            PolicyError: If the policy fails.
        """

    def close(self) -> None:
        """Close the policy and its connections."""


def opened(name: str | Policy, *, device: str = "cpu", keys: dict[str, str]) -> Source:
    """Return the policy with this name, which is ready to answer.

    Args:
        name: ``module:name`` or ``file.py:name``, as in ``tool0 collect``;
            ``lerobot:FOLDER`` for a pretrained LeRobot policy; ``ws://HOST:PORT`` for a
            server with openpi's protocol; or a function or class.
        device: Device on which LeRobot's policies run, such as ``cpu`` or ``cuda``.
        keys: Mapping from the names that an openpi server expects to the observed
            values.

    Raises:
        ConfigError: If there is no such policy.
        PolicyError: If the policy cannot be loaded.
        TransportError: If no server answers at the address.
    """
    if not isinstance(name, str):
        from tool0.policy.callables import CallablePolicy

        return CallablePolicy(name)
    if name.startswith(_SERVERS):
        from tool0.policy.openpi import OpenpiServer

        return OpenpiServer(name, keys)
    if keys:
        raise ConfigError("keys are those of an openpi server, ws://HOST:PORT")
    if name.startswith(LEROBOT):
        from tool0.policy.lerobot_policy import LeRobotPolicy

        return LeRobotPolicy(name.removeprefix(LEROBOT), device)
    from tool0.policy.callables import CallablePolicy

    return CallablePolicy(name)


def checked_chunk(actions: Any, width: int) -> Array:
    """Return a policy's actions as an array, shape (h, width).

    Raises:
        PolicyError: If the actions have a wrong shape or are not numbers.
    """
    try:
        found: Array = np.asarray(actions, np.float64)
    except (TypeError, ValueError):
        raise PolicyError(
            f"the policy returned {actions!r:.80}; it must return numbers of shape "
            f"({width},) or (h, {width})"
        ) from None
    if found.ndim == 1:
        found = found[None]
    if found.ndim != 2 or found.shape[1] != width or not len(found):
        raise PolicyError(
            f"the policy returned an array of shape {np.shape(actions)}; it must be "
            f"({width},) or (h, {width})"
        )
    return found
